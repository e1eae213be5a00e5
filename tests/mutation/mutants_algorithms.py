"""Every term of every algorithm, broken one by one."""

from mutant import Mutant, mutants

ON_OFF: list[Mutant] = mutants(
    "switch_lead", "algorithm_air.c",
    ("rate_k_per_s = 0.0f;", "rate_k_per_s = 1.0f;"),
    ("algorithm_air.rate_k_per_s = 0.0f;", ""),
    ("algorithm_air.heating = 0;", ""),
    ("if (gap == 1) {", "if (1) {"),
    ("if (gap == 1) {", "if (gap <= 2) {"),
    ("change_k * LOOP_AIR_PER_PERIOD", "-change_k * LOOP_AIR_PER_PERIOD"),
    ("rate_k_per_s += LOOP", "rate_k_per_s -= LOOP"),
    ("LOOP_AIR_RATE_WEIGHT * (slope - algorithm_air.rate_k_per_s)",
     "LOOP_AIR_RATE_WEIGHT * slope"),
    ("LOOP_AIR_RATE_WEIGHT * (", "("),
    ("loop_air.temperature_c + LOOP_AIR_LEAD_S", "loop_air.temperature_c - LOOP_AIR_LEAD_S"),
    (" + LOOP_AIR_LEAD_S * algorithm_air.rate_k_per_s", ""),
    ("expected_c < setpoint_c", "expected_c <= setpoint_c"),
    ("expected_c < setpoint_c", "expected_c > setpoint_c"),
    ("? 100.0f : 0.0f", "? 99.0f : 0.0f"),
    ("? 100.0f : 0.0f", "? 100.0f : 1.0f"),
) + mutants(
    "switch_lead_band", "algorithm_air.c",
    ("change_k * LOOP_AIR_PER_PERIOD", "change_k"),
    ("change_k * LOOP_AIR_PER_PERIOD", "change_k / 0.9f"),
) + mutants(
    "switch_band", "algorithm_air.c",
    ("expected_c >= setpoint_c + LOOP", "expected_c > setpoint_c + LOOP"),
    ("expected_c <= setpoint_c - LOOP", "expected_c < setpoint_c - LOOP"),
    ("setpoint_c + LOOP_AIR_HYSTERESIS_K", "setpoint_c"),
    ("setpoint_c - LOOP_AIR_HYSTERESIS_K", "setpoint_c"),
    ("algorithm_air.heating = 0;\n    } else", "} else"),
    ("algorithm_air.heating = 1;", ""),
) + mutants(
    "switch", "algorithm_air.c",
    ("expected_c < setpoint_c", "expected_c <= setpoint_c"),
    ("expected_c < setpoint_c", "!(expected_c < setpoint_c)"),
)  # fmt: skip

_GOES_ON = "set_integral(algorithm_air.integral + LOOP_AIR_KI_PER_STEP * error_k);"
_LIMITED = "limit(value, LOOP_AIR_INTEGRAL_MINIMUM, LOOP_AIR_INTEGRAL_MAXIMUM)"
_HELD = "algorithm_air.integral = before; /*"

PID: list[Mutant] = mutants(
    "pid_hold", "algorithm_air.c",
    ("setpoint_c - loop_air.temperature_c", "temperature_c - loop_air.setpoint_c"),
    ("algorithm_air.proportional = 0.0f;", ""),
    ("algorithm_air.integral = 0.0f;", ""),
    ("algorithm_air.derivative = 0.0f;", ""),
    ("algorithm_air.started = 0;", ""),
    ("algorithm_air.started = 1;", ""),
    ("return minimum;", "return value;"),
    ("return maximum;", "return value;"),
    ("value > maximum", "value > minimum"),
    ("if (gap == 1) {", "if (1) {"),
    ("if (gap == 1) {", "if (gap != 1) {"),
    ("slope = -(now - algorithm_air.last)", "slope = (now - algorithm_air.last)"),
    ("if (algorithm_air.started) {", "if (1) {"),
    ("derivative += LOOP_AIR_SLOPE_WEIGHT", "derivative = LOOP_AIR_SLOPE_WEIGHT"),
    ("LOOP_AIR_SLOPE_WEIGHT * (slope - algorithm_air.derivative)",
     "LOOP_AIR_SLOPE_WEIGHT * slope"),
    ("LOOP_AIR_SLOPE_WEIGHT * (slope", "(slope"),
    ("algorithm_air.last = now;", ""),
    ("    }\n    algorithm_air.last = now;", "    algorithm_air.last = now;\n    }"),
    ("differentiate(error_k, gap);", ""),
    ("sum += algorithm_air.integral;", ""),
    ("sum += LOOP_AIR_KD * algorithm_air.derivative;", ""),
    ("sum += LOOP_AIR_KD", "sum -= LOOP_AIR_KD"),
    ("float sum = algorithm_air.proportional;", "float sum = 0.0f;"),
    ("proportional = LOOP_AIR_KP * error_k;", "proportional = error_k;"),
    ("algorithm_air.proportional = LOOP_AIR_KP * error_k;", ""),
    ("LOOP_AIR_KI_PER_STEP * error_k", "error_k"),
    ("integral + LOOP_AIR_KI_PER_STEP", "integral - LOOP_AIR_KI_PER_STEP"),
    (_GOES_ON, ""),
    (_HELD, "/*"),
    ("sum > LOOP_AIR_OUTPUT_MAXIMUM", "sum >= LOOP_AIR_OUTPUT_MINIMUM"),
    ("sum > LOOP_AIR_OUTPUT_MAXIMUM", "0"),
    ("sum < LOOP_AIR_OUTPUT_MINIMUM", "0"),
    ("sum < LOOP_AIR_OUTPUT_MINIMUM && error_k < 0.0f",
     "sum < LOOP_AIR_OUTPUT_MINIMUM"),
    ("const float before = algorithm_air.integral;", "const float before = 0.0f;"),
    ("limit(integrate(error_k), LOOP_AIR_OUTPUT_MINIMUM, LOOP_AIR_OUTPUT_MAXIMUM)",
     "limit(integrate(error_k), LOOP_AIR_OUTPUT_MINIMUM, 1e9f)"),
    ("limit(integrate(error_k), LOOP_AIR_OUTPUT_MINIMUM,", "limit(integrate(error_k), -1.0f,"),
    ("return sum;\n}\n\n/* What", "return algorithm_air_unlimited();\n}\n\n/* What"),
) + mutants(
    "pi_hold", "algorithm_air.c",
    ("set_integral(0.0f);", ""),
    ("if (!algorithm_air.started) {", "if (algorithm_air.started) {"),
) + mutants(
    "pid_error_run", "algorithm_air.c",
    ("const float now = error_k;", "const float now = loop_air.temperature_c;"),
    ("slope = (now - algorithm_air.last)", "slope = -(now - algorithm_air.last)"),
    ("(now - algorithm_air.last) * LOOP_AIR_PER_PERIOD", "(now - algorithm_air.last)"),
    (_GOES_ON, f"const float before = algorithm_air.integral;\n{_GOES_ON}\n"
     "if (algorithm_air_unlimited() > LOOP_AIR_OUTPUT_MAXIMUM && error_k > 0.0f) "
     "{ algorithm_air.integral = before; }"),
    ("integrate(error_k), LOOP_AIR_OUTPUT_MINIMUM", "integrate(error_k), 0.0f"),
) + mutants(
    "pid_error_run", "algorithm_air.c",
    (_LIMITED, _LIMITED.replace("LOOP_AIR_INTEGRAL_MINIMUM", "-1e9f")),
    (_LIMITED, _LIMITED.replace("LOOP_AIR_INTEGRAL_MAXIMUM", "1e9f")),
) + mutants(
    "pid_hold", "algorithm_air.c",
    ("sum > LOOP_AIR_OUTPUT_MAXIMUM && error_k > 0.0f",
     "sum > LOOP_AIR_OUTPUT_MAXIMUM"),
) + mutants(
    "p", "algorithm_air.c",
    ("LOOP_AIR_KP * error_k", "LOOP_AIR_KP * error_k + 0.001f"),
    ("LOOP_AIR_OUTPUT_MAXIMUM)", "100.0f)"),
) + mutants(
    "pd", "algorithm_air.c",
    ("algorithm_air.started = 0;", ""),
    ("sum += LOOP_AIR_KD * algorithm_air.derivative;", "sum += LOOP_AIR_KD;"),
)  # fmt: skip

ALL = [*ON_OFF, *PID]
