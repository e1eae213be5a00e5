"""The control step and the fault's latch, broken one by one."""

from mutant import Mutant, mutants

LOOP: list[Mutant] = mutants(
    "pid_hold", "loop_air.c",
    ("loop_air.steps++;", ""),
    ("loop_air.setpoint_c = settings.air_setpoint_c;", ""),
    ("sensor_air_celsius(loop_air.reading_raw)", "(float)loop_air.reading_raw * 0.125f"),
    ("sensor_air_celsius(loop_air.reading_raw)",
     "(float)(uint16_t)loop_air.reading_raw * SENSOR_AIR_STEP_C"),
    ("uint16_t gap = 1;", "uint8_t gap = 1;"),
    ("(loop_air.missing + 1u)", "(loop_air.missing)"),
    ("(uint16_t)(loop_air.missing + 1u)", "(uint8_t)(loop_air.missing + 1u)"),
    ("if (loop_air.has_reading) {", "if (true) {"),
    ("change_k = loop_air.temperature_c - last_c;", ""),
    ("loop_air.missing = 0;", ""),
    ("loop_air.has_reading = 1;", ""),
    ("loop_air.missing < UINT8_MAX", "true"),
    ("loop_air.missing < UINT8_MAX", "loop_air.missing < UINT8_MAX - 1"),
    ("loop_air.missing++;", ""),
    ("guard_air_step(change_k, gap);", ""),
    ("guard_air_step(change_k, gap);", "if (ok) { guard_air_step(change_k, gap); }"),
    ("algorithm_air_reset();", ""),
    ("algorithm_air_reset();\n        loop_air.duty_percent = 0.0f;", "algorithm_air_reset();"),
    ("loop_air.duty_percent = 0.0f; /*", "/*"),
    ("if (fault.code != FAULT_NONE) {", "if (false) {"),
    ("} else if (!ok) {", "} else if (false) {"),
    ("gate_renew_air_sensor();", ""),
    ("gate_renew_air();\n}", "}"),
    ("output_heater_set(loop_air.duty_percent);", ""),
    ("output_heater_set(loop_air.duty_percent);",
     "if (ok) { output_heater_set(loop_air.duty_percent); }"),
    ("if (ok || fault.code != FAULT_NONE) {", "if (true) {"),
    ("if (ok || fault.code != FAULT_NONE) {", "if (ok) {"),
    ("if (ok || fault.code != FAULT_NONE) {", "if (fault.code != FAULT_NONE) {"),
    ("loop_air.asked_percent = loop_air.duty_percent;", ""),
    ("ticks_left = LOOP_AIR_PERIOD_TICKS;\n    sensor", "ticks_left = 1;\n    sensor"),
    ("ticks_left = LOOP_AIR_PERIOD_TICKS;\n    step", "ticks_left = 101;\n    step"),
) + mutants(
    "switch_lead", "loop_air.c",
    ("loop_air.temperature_c - last_c", "last_c - loop_air.temperature_c"),
    ("uint16_t gap = 1;", "uint8_t gap = 1;"),
)  # fmt: skip

FAULT: list[Mutant] = mutants(
    "switch_lead", "fault.c",
    ("fault.code = code;", ""),
    ("fault.temperature_c = temperature_c;", ""),
    ("fault.code = FAULT_NONE;", ""),
    ("fault.acknowledgements++;", ""),
    ("guard_air_reset();", ""),
    ("if (fault.code == FAULT_NONE) {\n        return;\n    }", ""),
    ("fault.time_s = clock_seconds();", ""),
    ("settings_save();\n}\n\nvoid", "}\n\nvoid"),
    ("if (fault.code != FAULT_NONE) {\n        return;\n    }", ""),
    ("guard_air_reset();\n    settings_save();", "guard_air_reset();"),
)  # fmt: skip

ALL = [*LOOP, *FAULT]
