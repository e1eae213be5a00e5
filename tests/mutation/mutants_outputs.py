"""Outputs and the gate before them, broken one by one."""

from mutant import Mutant, mutants

OUTPUTS: list[Mutant] = mutants(
    "switch", "output_heater.c",
    ("duty_percent > 0.0f", "duty_percent > 100.0f"),
    ("permitted && wanted", "wanted"),
    ("permitted && wanted", "permitted"),
    ("pin_output_heater_off();", ""),
    ("pin_output_heater_on();", ""),
) + mutants(
    "pi_hold", "output_heater.c",
    ("+ 0.5f", ""),
    ("OUTPUT_HEATER_STEPS_PER_PERCENT", "0.5f * OUTPUT_HEATER_STEPS_PER_PERCENT"),
    ("steps < OUTPUT_HEATER_MINIMUM_ON_STEPS", "steps <= OUTPUT_HEATER_MINIMUM_ON_STEPS"),
    ("steps = 0;\n    }", "}"),
    ("steps > OUTPUT_HEATER_WINDOW_STEPS - OUTPUT", "steps >= OUTPUT_HEATER_WINDOW_STEPS - OUTPUT"),
    ("steps = OUTPUT_HEATER_WINDOW_STEPS;", ""),
    ("output_heater.on_steps = steps;", ""),
    ("running = true;", ""),
    ("window_tick < on_ticks", "window_tick <= on_ticks"),
    ("window_tick++;", ""),
    ("window_tick == OUTPUT_HEATER_WINDOW_TICKS",
     "window_tick > OUTPUT_HEATER_WINDOW_TICKS"),
    ("pin_output_heater_off();", ""),
) + mutants(
    "pid_hold", "output_heater.c",
    ("on_ticks = 0;", ""),
    ("if (window_tick == 0) {", "if (true) {"),
    ("if (running) {", "if (true) {"),
) + mutants(
    "pd", "output_heater.c",
    ("output_heater.on_steps * OUTPUT_HEATER_TICKS_PER_STEP", "output_heater.on_steps"),
    ("steps < OUTPUT_HEATER_MINIMUM_ON_STEPS", "steps < 1"),
) + mutants(
    "p", "output_heater.c",
    ("+ 0.5f", "+ 1.0f"),
    ("output_heater.on_counts = counts;", ""),
    ("(counts - 1u)", "(counts)"),
    ("counts == 0", "counts <= 1"),
    ("counts >= OUTPUT_HEATER_PERIOD_COUNTS", "counts > OUTPUT_HEATER_PERIOD_COUNTS / 2"),
) + mutants(
    "pi_run", "output_heater.c",
    ("(uint16_t)(counts - 1u)", "(uint8_t)(counts - 1u)"),
    ("OUTPUT_HEATER_COUNTS_PER_PERCENT", "2.56f"),
)  # fmt: skip

GATE: list[Mutant] = mutants(
    "switch_lead", "gate.c",
    ("main_ticks != 0 && fault.code == FAULT_NONE", "fault.code == FAULT_NONE"),
    ("main_ticks != 0 && fault.code == FAULT_NONE", "main_ticks != 0"),
    ("if (!spend(&air_ticks)) {", "if (false) {"),
    ("if (!spend(&air_sensor_ticks)) {", "if (false) {"),
    ("if (!spend(&air_sensor_ticks)) {", "if (!spend(&air_ticks)) {"),
    ("reset_hang_mark = RESET_HANG_MARK;", ""),
    ("reset_hang_mark = 0;", ""),
    ("if (main_ticks == 0) {", "if (main_ticks <= 1) {"),
    ("bool air_permitted = healthy;", "bool air_permitted = true;"),
    ("if (!output_fan_is_on()) {", "if (false) {"),
    ("if (!output_fan_is_on()) {", "if (output_fan_is_on()) {"),
    ("output_heater_tick(air_permitted);", "output_heater_tick(true);"),
    ("(*ticks)--;", ""),
    ("if (*ticks == 0) {\n        return false;\n    }", ""),
    ("if (*ticks == 0)", "if (*ticks <= 1)"),
    ("*ticks = count;", "*ticks += count;"),
    ("main_ticks--;", ""),
    ("main_ticks = GATE_MAIN_PERMIT_TICKS;", "main_ticks = 2u * GATE_MAIN_PERMIT_TICKS;"),
    ("main_ticks = GATE_MAIN_PERMIT_TICKS;", ""),
    ("LOOP_AIR_PERMIT_TICKS", "LOOP_AIR_SENSOR_PERMIT_TICKS"),
    ("LOOP_AIR_SENSOR_PERMIT_TICKS", "LOOP_AIR_PERMIT_TICKS"),
)  # fmt: skip

ALL = [*OUTPUTS, *GATE]
