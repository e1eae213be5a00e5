"""Firmware that a host commands, of every shape: what matrix is for the rest."""

from itertools import combinations

from matrix import PINS, Row, drawn, fewest

CHOICES: dict[str, tuple[str, ...]] = {
    "board": (
        "uno", "nano", "mega2560", "leonardo", "atmega328p", "atmega2560", "atmega1284p",
        "atmega32",  # the ATmega16 has the same registers, and too little flash
    ),
    "algorithm": ("on_off", "pid"),
    "autotune": ("", "{}", "{cycles: 3, swing: 80 %, timeout: 10 min}"),
    "band": ("", "10 K"),
    "dead_band": ("", "0.1 K"),
    "kd": ("0", "30"),
    "ki": ("0", "0.3"),
    "tools": ("T0: air", "T0: air, T1: bed", "T3: bed, T1: air", "T5: bed"),
    "fan": ("", "digital", "pwm"),
    "feed": ("", "high", "low"),
    "keys": ("no", "yes"),
    "stored": ("false", "true"),
    "frequency": ("30 Hz", "100 Hz"),
    "supply": ("12 V", "12 V, rated: 9 V"),
    "baud": ("9600", "57600"),
}  # fmt: skip

# Step, direction and enable of the feed, its heater, the fan.
WIRES = {
    **dict.fromkeys(("uno", "nano"), ("D11", "D13", "A5", "D3", "A2")),
    "leonardo": ("D11", "D13", "A5", "D3", "A2"),
    "mega2560": ("D25", "D26", "D27", "D22", "D28"),
    "atmega328p": ("PC2", "PC4", "PC5", "PD2", "PD4"),
    "atmega2560": ("PA1", "PA2", "PA3", "PA0", "PA4"),
    **dict.fromkeys(("atmega1284p", "atmega32"), ("PA2", "PA5", "PA6", "PA0", "PA4")),
}
SENSOR = (
    "{{kind: thermistor, pin: {pin}, divider: {{pull_up: 4.7 kΩ}}, oversample: 4, "
    "curve: {{resistance: 100 kΩ, at: 25 °C, beta: 4267 K}}, range: 0 °C .. 300 °C}}"
)


def can_be(row: Row) -> bool:
    """Tell what the language allows."""
    if row["keys"] == "yes" and row["board"] not in {"uno", "leonardo", "mega2560"}:
        return False
    serves_air = "air" in row["tools"]
    if row["autotune"] and not (row["algorithm"] == "pid" and serves_air):
        return False
    if row["feed"] and not serves_air:
        return False
    if row["feed"] and row["fan"] == "pwm" and row["board"] == "leonardo":
        return False  # three timers, one of them with a single channel
    return row["fan"] != "pwm" or row["algorithm"] != "on_off"


def spec_of(row: Row) -> str:
    """Write the spec."""
    board = row["board"]
    step, direction, enable, heater, fan = WIRES[board]
    _, second, _, sensor, other, *_ = PINS[board]
    kind = "digital" if row["algorithm"] == "on_off" else "pwm"
    frequency = f", frequency: {row['frequency']}" if kind == "pwm" else ""
    outputs = {
        "heater": f"{{kind: {kind}, pin: {heater}{frequency}, power: 40 W"
        f"{', supply: ' + row['supply'] if kind == 'pwm' else ''}}}",
        "hot_bed": f"{{kind: digital, pin: {second}, power: 100 W}}",
    }
    if row["fan"]:
        more = f", frequency: {row['frequency']}" if row["fan"] == "pwm" else ""
        outputs["blower"] = f"{{kind: {row['fan']}, pin: {fan}{more}}}"
    if row["feed"]:
        outputs["feed"] = (
            f"{{kind: stepper, step: {step}, direction: {direction}, enable: {enable},"
            f" enable_active: {row['feed']}, steps: 200, microsteps: 16, lead: 25 mm,"
            " maximum: 20 mm/s, acceleration: 50 mm/s²}"
        )
    sensors = {"air": SENSOR.format(pin=sensor), "bed_2": SENSOR.format(pin=other)}
    loops = {"air": _loop(row), "bed": _bed(row)}
    lines = [f"heatwright: 1\ncontroller: {{name: shape, board: {board}}}"]
    for section, entries in {"sensors": sensors, "outputs": outputs, "loops": loops}.items():
        lines += [f"{section}:", *(f"  {name}: {text}" for name, text in entries.items())]
    return "\n".join([*lines, "interfaces:", *_interfaces(row)]) + "\n"


def _interfaces(row: Row) -> list[str]:
    fans = ", fans: {P1: blower}" if row["fan"] else ""
    feed = ", steppers: {E: feed}" if row["feed"] else ""
    host = f"  - {{kind: gcode, baud: {row['baud']}, loops: {{{row['tools']}}}{fans}{feed}}}"
    keys = "  - {kind: lcd_keypad, loop: air}"
    return [host, keys] if row["keys"] == "yes" else [host]


PROTECTION = "{maximum: 280 °C, minimum: 5 °C, rise_rate: 20 K/s, frozen: off}"


def _loop(row: Row) -> str:
    autotune = f", autotune: {row['autotune']}" if row["autotune"] else ""
    ready = ", ready_within: 2 K" if row["feed"] else ""
    return (
        f"{{sensor: air, heater: heater, period: 500 ms, algorithm: {_algorithm(row)}{autotune}"
        f"{ready}, setpoint: {{initial: 20 °C, minimum: 10 °C, maximum: 250 °C,"
        f" stored: {row['stored']}}}, protection: {PROTECTION}}}"
    )


def _bed(row: Row) -> str:
    return (
        "{sensor: bed_2, heater: hot_bed, period: 1 s, algorithm: {kind: on_off},"
        f" setpoint: {{initial: 20 °C, minimum: 10 °C, maximum: 110 °C, stored: {row['stored']}}},"
        f" protection: {PROTECTION}}}"
    )


def _algorithm(row: Row) -> str:
    if row["algorithm"] == "on_off":
        return "{kind: on_off, hysteresis: 1 K}"
    bands = "".join(f", {key}: {row[key]}" for key in ("band", "dead_band") if row[key])
    return f"{{kind: pid, kp: 9, ki: {row['ki']}, kd: {row['kd']}, derivative_filter: 1 s{bands}}}"


def telling(row: Row) -> Row:
    """Return the choices that the firmware shows."""
    silent = {"supply", "frequency"} if row["algorithm"] == "on_off" else set()
    if row["algorithm"] == "on_off":
        silent |= {"band", "dead_band", "kd", "ki"}
    return {choice: value for choice, value in row.items() if choice not in silent}


def pairs(row: Row) -> frozenset[object]:
    """Return every two choices that meet in a row."""
    return frozenset(combinations(sorted(telling(row).items()), 2))


def pairwise(seed: int = 7) -> list[Row]:
    """Return few rows in which every two choices meet that can; the same in every run."""
    return fewest(drawn(CHOICES, seed, 4000, can_be), pairs)
