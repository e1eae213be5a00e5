"""Protections, broken one by one."""

from mutant import Mutant, mutants

READINGS: list[Mutant] = mutants(
    "switch", "guard_air.c",
    ("temperature_c >= LOOP_AIR_MAXIMUM_C", "temperature_c > LOOP_AIR_MAXIMUM_C"),
    ("temperature_c >= LOOP_AIR_MAXIMUM_C", "temperature_c < LOOP_AIR_MAXIMUM_C"),
    ("LOOP_AIR_MAXIMUM_C", "LOOP_AIR_MAXIMUM_C + 0.0625f"),
    ("return FAULT_OVER_TEMPERATURE;", "return FAULT_UNDER_TEMPERATURE;"),
    ("return FAULT_OVER_TEMPERATURE;", ""),
    ("temperature_c <= LOOP_AIR_MINIMUM_C", "temperature_c < LOOP_AIR_MINIMUM_C"),
    ("LOOP_AIR_MINIMUM_C", "LOOP_AIR_MAXIMUM_C"),
    ("return FAULT_UNDER_TEMPERATURE;", ""),
    ("change_k > allowed_k ||", ""),
    ("|| change_k < -allowed_k", ""),
    ("change_k < -allowed_k", "change_k < allowed_k"),
    ("LOOP_AIR_RISE_PER_STEP_K * (float)gap", "LOOP_AIR_RISE_PER_STEP_K"),
    ("LOOP_AIR_RISE_PER_STEP_K * (float)gap", "LOOP_AIR_RISE_PER_STEP_K * (float)(uint8_t)gap"),
    ("return FAULT_RISE_RATE;", ""),
    ("missing >= LOOP_AIR_STALE_STEPS", "missing > LOOP_AIR_STALE_STEPS"),
    ("missing >= LOOP_AIR_STALE_STEPS", "missing >= LOOP_AIR_STALE_STEPS - 1u"),
    ("fault_trip(loop_air.reading_status, loop_air.temperature_c);", ""),
    ("fault_trip(loop_air.reading_status,", "fault_trip(FAULT_SENSOR_STALE,"),
    ("fault_trip(loop_air.reading_status, loop_air.temperature_c)",
     "fault_trip(loop_air.reading_status, 0.0f)"),
    ("fault_trip(code, loop_air.temperature_c)", "fault_trip(code, 0.0f)"),
    ("fault_trip(code, loop_air.temperature_c);", ""),
    ("loop_air.reading_status == READING_OK", "loop_air.reading_status <= 1"),
    ("if (fault.code != FAULT_NONE) {\n        return;\n    }", ""),
    ("start_afresh_if_needed();\n    const", "const"),
) + mutants(
    "switch_lead", "guard_air.c",
    ("change_k > allowed_k", "change_k >= allowed_k"),
    ("change_k < -allowed_k", "change_k <= -allowed_k"),
    ("LOOP_AIR_RISE_PER_STEP_K *", "1.02f * LOOP_AIR_RISE_PER_STEP_K *"),
    ("LOOP_AIR_RISE_PER_STEP_K *", "0.99f * LOOP_AIR_RISE_PER_STEP_K *"),
)  # fmt: skip

FRESH: list[Mutant] = mutants(
    "switch", "guard_air.c",
    ("guard_air.fresh = 1;", ""),
    ("guard_air.fresh = 0;", ""),
    ("guard_air.setpoint_last_c = loop_air.setpoint_c;", ""),
    ("loop_air.setpoint_c == guard_air.setpoint_last_c", "true"),
    ("loop_air.setpoint_c == guard_air.setpoint_last_c", "false"),
    ("loop_air.setpoint_c == guard_air.setpoint_last_c",
     "loop_air.setpoint_c >= guard_air.setpoint_last_c"),
    ("guard_air.in_band = 0;\n    guard_air.runaway_steps = 0;\n    guard_air.heating",
     "guard_air.runaway_steps = 0;\n    guard_air.heating"),
    ("guard_air.runaway_steps = 0;\n    guard_air.heating_steps", "guard_air.heating_steps"),
    ("guard_air.heating_steps = 0;\n    guard_air.frozen_steps", "guard_air.frozen_steps"),
    ("guard_air.frozen_steps = 0;\n    guard_air.off_steps", "guard_air.off_steps"),
    ("guard_air.off_steps = 0;\n}", "}"),
    ("guard_air.in_band = 0;\n    guard_air.runaway_steps = 0;\n}",
     "guard_air.runaway_steps = 0;\n}"),
)  # fmt: skip

RUNAWAY: list[Mutant] = mutants(
    "switch", "guard_air.c",
    ("setpoint_c + LOOP_AIR_RUNAWAY_ABOVE_K", "setpoint_c - LOOP_AIR_RUNAWAY_ABOVE_K"),
    ("setpoint_c - LOOP_AIR_RUNAWAY_BELOW_K", "setpoint_c + LOOP_AIR_RUNAWAY_BELOW_K"),
    ("setpoint_c - LOOP_AIR_RUNAWAY_BELOW_K", "setpoint_c - LOOP_AIR_RUNAWAY_ABOVE_K"),
    ("t <= high_c", "t < high_c"),
    ("t >= low_c", "t > low_c"),
    ("guard_air.in_band |= MET_ABOVE;", ""),
    ("guard_air.in_band |= MET_BELOW;", ""),
    ("guard_air.in_band |= MET_BELOW;", "guard_air.in_band = MET_BELOW;"),
    ("guard_air.in_band & MET_ABOVE", "true"),
    ("guard_air.in_band & MET_BELOW", "true"),
    ("guard_air.in_band & MET_BELOW", "guard_air.in_band & MET_ABOVE"),
    ("code = FAULT_RUNAWAY_ABOVE;", ""),
    ("code = FAULT_RUNAWAY_BELOW;", ""),
    ("code = FAULT_RUNAWAY_BELOW;", "code = FAULT_RUNAWAY_ABOVE;"),
    ("guard_air.runaway_steps = 0;\n        return FAULT_NONE;", "return FAULT_NONE;"),
    ("guard_air.runaway_steps++;", ""),
    ("runaway_steps >= LOOP_AIR_RUNAWAY_STEPS", "runaway_steps > LOOP_AIR_RUNAWAY_STEPS"),
    ("? code : FAULT_NONE", "? FAULT_NONE : FAULT_NONE"),
    ("if (code != FAULT_NONE) {\n        return code;\n    }", ""),
) + mutants(
    "switch_lead", "guard_air.c",
    ("t <= high_c", "t < high_c"),
    ("runaway_steps >= LOOP_AIR_RUNAWAY_STEPS", "runaway_steps >= LOOP_AIR_RUNAWAY_STEPS - 1u"),
)  # fmt: skip

HEATING: list[Mutant] = mutants(
    "switch", "guard_air.c",
    ("asked_percent < LOOP_AIR_FULL_DUTY_PERCENT", "asked_percent <= LOOP_AIR_FULL_DUTY_PERCENT"),
    ("loop_air.asked_percent < LOOP_AIR_FULL_DUTY_PERCENT\n        ||", ""),
    ("|| t >= guard_air.heating_from_c + LOOP_AIR_HEATING_RISE_K", ""),
    ("t >= guard_air.heating_from_c +", "t > guard_air.heating_from_c +"),
    ("heating_from_c + LOOP_AIR_HEATING_RISE_K", "heating_from_c - LOOP_AIR_HEATING_RISE_K"),
    ("guard_air.heating_steps = 0;\n        guard_air.heating_from_c", "guard_air.heating_from_c"),
    ("guard_air.heating_from_c = t;\n        return", "return"),
    ("guard_air.heating_steps++;", ""),
    ("guard_air.heating_steps++;", "guard_air.heating_steps += 2;"),
    ("heating_steps >= LOOP_AIR_HEATING_STEPS", "heating_steps > LOOP_AIR_HEATING_STEPS"),
    ("if (heating_failed()) {\n        return FAULT_HEATING_FAILED;\n    }", ""),
    ("return FAULT_HEATING_FAILED;", "return FAULT_SENSOR_FROZEN;"),
) + mutants(
    "p", "guard_air.c",
    ("LOOP_AIR_FULL_DUTY_PERCENT", "100.0f"),
)  # fmt: skip

FROZEN: list[Mutant] = mutants(
    "switch", "guard_air.c",
    ("loop_air.reading_raw != guard_air.frozen_raw\n        ||", ""),
    ("|| loop_air.asked_percent == 0.0f", ""),
    ("|| loop_air.temperature_c >= loop_air.setpoint_c", ""),
    ("reading_raw != guard_air.frozen_raw", "reading_raw > guard_air.frozen_raw"),
    ("guard_air.frozen_steps = 0;\n        guard_air.frozen_raw", "guard_air.frozen_raw"),
    ("guard_air.frozen_raw = loop_air.reading_raw;\n        return", "return"),
    ("guard_air.frozen_steps++;", ""),
    ("frozen_steps >= LOOP_AIR_FROZEN_STEPS", "frozen_steps > LOOP_AIR_FROZEN_STEPS"),
    ("if (frozen()) {\n        return FAULT_SENSOR_FROZEN;\n    }", ""),
) + mutants(
    "pi_hold", "guard_air.c",
    ("temperature_c >= loop_air.setpoint_c", "temperature_c > loop_air.setpoint_c"),
)  # fmt: skip

RISING: list[Mutant] = mutants(
    "switch", "guard_air.c",
    ("guard_air.off_steps = 0;\n        return", "return"),
    ("loop_air.duty_percent > 0.0f", "loop_air.duty_percent >= 0.0f"),
    ("off_steps < LOOP_AIR_OFF_SETTLE_STEPS", "off_steps <= LOOP_AIR_OFF_SETTLE_STEPS"),
    ("guard_air.off_steps++;", ""),
    ("guard_air.off_lowest_c = t;\n        return", "return"),
    ("if (t < guard_air.off_lowest_c) {", "if (t > guard_air.off_lowest_c) {"),
    ("guard_air.off_lowest_c = t;\n    }\n    return", "}\n    return"),
    ("return t >= guard_air.off_lowest_c", "return t > guard_air.off_lowest_c"),
    ("off_lowest_c + LOOP_AIR_OFF_RISE_K", "off_lowest_c - LOOP_AIR_OFF_RISE_K"),
    ("off_lowest_c + LOOP_AIR_OFF_RISE_K", "off_lowest_c + 2.0f * LOOP_AIR_OFF_RISE_K"),
    ("if (rising_while_off()) {\n        return FAULT_RISING_WHILE_OFF;\n    }", ""),
)  # fmt: skip

ALL = [*READINGS, *FRESH, *RUNAWAY, *HEATING, *FROZEN, *RISING]
