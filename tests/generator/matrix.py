"""Firmware of every shape: few specs in which every two choices meet."""

import random
from collections.abc import Callable, Mapping
from itertools import combinations

Row = Mapping[str, str]

CHOICES: dict[str, tuple[str, ...]] = {
    "board": (
        "uno", "nano", "mega2560", "leonardo", "atmega328p", "atmega2560", "atmega1284p",
        "atmega32", "atmega16",
    ),
    "output": ("digital", "pwm8a", "pwm8b", "pwm16", "time_proportional"),
    "active": ("high", "low"),
    "algorithm": ("on_off", "pid"),
    "lead": ("0 s", "12 s"),
    "hysteresis": ("0 K", "0.5 K"),
    "ki": ("0", "0.05"),
    "kd": ("0", "180"),
    "derivative_of": ("measurement", "error"),
    "while_limited": ("hold", "run"),
    "minimum_on": ("0 s", "40 ms"),
    "minimum_off": ("0 s", "60 ms"),
    "off": ("", "heating", "runaway", "frozen", "rising_while_off"),
    "below": ("", "8 K"),
    "stored": ("false", "true"),
    "interface": ("none", "lcd", "plotter", "both"),
    "sensor": ("ds18b20", "thermistor", "rtd", "analog", "max6675", "max31855", "max31856"),
    "bits": ("9", "10", "11", "12"),
    "loops": ("1", "2"),
    "fan": ("no", "yes"),
}  # fmt: skip

FEW_TIMERS = {"uno", "nano", "atmega328p", "leonardo", "atmega32", "atmega16"}
NO_SHIELD = {"nano", "atmega328p", "atmega2560", "atmega1284p", "atmega32", "atmega16"}

# A pin with a timer's compare output for each kind of PWM, by board.
PWM_PINS = {
    "uno": {"pwm8a": "D6", "pwm8b": "D3", "pwm16": "D10"},
    "nano": {"pwm8a": "D6", "pwm8b": "D5", "pwm16": "D9"},
    "mega2560": {"pwm8a": "D10", "pwm8b": "D4", "pwm16": "D46"},
    "leonardo": {"pwm8a": "D11", "pwm8b": "D3", "pwm16": "D10"},
    "atmega328p": {"pwm8a": "PD6", "pwm8b": "PD3", "pwm16": "PB1"},
    "atmega2560": {"pwm8a": "PB4", "pwm8b": "PG5", "pwm16": "PL5"},
    "atmega1284p": {"pwm8a": "PD7", "pwm8b": "PD6", "pwm16": "PD5"},
    # One channel to an 8-bit timer: a timer each.
    "atmega32": {"pwm8a": "PB3", "pwm8b": "PD7", "pwm16": "PD5"},
    "atmega16": {"pwm8a": "PB3", "pwm8b": "PD7", "pwm16": "PD5"},
}
SHIELD = {"D4", "D5", "D6", "D7", "D8", "D9", "D10"}
"""Pins of the LCD keypad shield."""

# Heater, second heater, fan, sensors, and three more wires of a converter: D2 and its like, free of
# everything else. The first sensor's pin has a channel of the ADC.
PINS = {
    **dict.fromkeys(
        ("uno", "nano", "leonardo"), ("D2", "D12", "A2", "A1", "A3", "A4", "A5", "D13")
    ),
    "mega2560": ("D22", "A9", "D41", "A1", "A3", "D42", "D25", "D26"),
    "atmega328p": ("PD2", "PB4", "PC2", "PC1", "PC3", "PC4", "PC5", "PB5"),
    "atmega2560": ("PA0", "PK1", "PJ6", "PF1", "PF3", "PL2", "PA1", "PL3"),
    **dict.fromkeys(
        ("atmega1284p", "atmega32", "atmega16"),
        ("PA0", "PA7", "PC6", "PA1", "PA3", "PA2", "PA4", "PA5"),
    ),
}

SENSORS = {
    "ds18b20": "pin: {pin}, resolution: {bits} bit",
    "thermistor": "pin: {pin}, divider: {{pull_up: 4.7 kΩ}}, oversample: 4, "
    "curve: {{resistance: 100 kΩ, at: 25 °C, beta: 3950 K}}, range: -5 °C .. 150 °C",
    "rtd": "pin: {pin}, element: pt1000, divider: {{pull_up: 1 kΩ}}, oversample: 8, "
    "range: -50 °C .. 150 °C",
    "analog": "pin: {pin}, scale: 10 mV/K, offset: 500 mV, range: -30 °C .. 120 °C",
    "max6675": "chip_select: {pin}, clock: {clock}, data_out: {data}",
    "max31855": "chip_select: {pin}, clock: {clock}, data_out: {data}, thermocouple: T",
    "max31856": "chip_select: {pin}, clock: {clock}, data_in: {told}, data_out: {data}, average: 4",
}


def can_be(row: Row) -> bool:
    """Tell what the language allows; the rest has its own messages, and its own tests."""
    if row["algorithm"] == "pid" and row["output"] == "digital":
        return False
    if row["loops"] == "2" and row["output"].startswith("pwm") and row["board"] in FEW_TIMERS:
        return False
    if row["interface"] not in {"lcd", "both"}:
        return True
    return row["board"] not in NO_SHIELD and heater_pin(row) not in SHIELD


def heater_pin(row: Row) -> str:
    """Return the pin of the heater: PWM needs certain ones."""
    return PWM_PINS[row["board"]].get(row["output"], PINS[row["board"]][0])


def spec_of(row: Row) -> str:
    """Write the spec."""
    _, second, fan, _, other, *_ = PINS[row["board"]]
    outputs = {"heater": _output(row, heater_pin(row))}
    sensors = {"air": _sensor(row)}
    loops = {"air": _loop(row, "air", "heater")}
    if row["fan"] == "yes":
        outputs["fan"] = f"{{kind: digital, pin: {fan}, runs: always, active: {row['active']}}}"
    if row["loops"] == "2":
        outputs["hot_bed"] = f"{{kind: digital, pin: {second}, power: 100 W}}"
        sensors["bed_2"] = f"{{kind: ds18b20, pin: {other}}}"
        loops["bed"] = (
            "{sensor: bed_2, heater: hot_bed, period: 2 s, algorithm: {kind: on_off},"
            " setpoint: {initial: 20 °C, minimum: 10 °C, maximum: 70.5 °C}}"
        )
    sections = {"sensors": sensors, "outputs": outputs, "loops": loops}
    lines = [f"heatwright: 1\ncontroller: {{name: shape, board: {row['board']}}}"]
    for section, entries in sections.items():
        lines += [f"{section}:", *(f"  {name}: {text}" for name, text in entries.items())]
    kinds = {"lcd": ["lcd_keypad"], "plotter": ["serial_plotter"], "none": []}
    shown = kinds.get(row["interface"], ["lcd_keypad", "serial_plotter"])
    lines += ["interfaces:", *(f"  - {{kind: {kind}, loop: air}}" for kind in shown)]
    return "\n".join(lines if shown else lines[:-1]) + "\n"


def _sensor(row: Row) -> str:
    *_, pin, _, clock, data, told = PINS[row["board"]]
    places = {"pin": pin, "clock": clock, "data": data, "told": told}
    wires = SENSORS[row["sensor"]].format(**places, bits=row["bits"])
    return f"{{kind: {row['sensor']}, {wires}}}"


def _output(row: Row, pin: str) -> str:
    common = f"pin: {pin}, active: {row['active']}, power: 240 W"
    if row["output"] == "digital":
        return f"{{kind: digital, {common}}}"
    if row["output"] == "pwm16":
        return f"{{kind: pwm, {common}, frequency: 100 Hz}}"
    if row["output"].startswith("pwm"):
        return f"{{kind: pwm, {common}, frequency: 976.5625 Hz}}"
    minima = f"minimum_on: {row['minimum_on']}, minimum_off: {row['minimum_off']}"
    return f"{{kind: time_proportional, {common}, window: 2 s, resolution: 20 ms, {minima}}}"


def _algorithm(row: Row) -> str:
    if row["algorithm"] == "on_off":
        lead = f", lead: {row['lead']}, lead_filter: 4 s" if row["lead"] != "0 s" else ""
        return f"{{kind: on_off, hysteresis: {row['hysteresis']}{lead}}}"
    gains = f"kp: 8, ki: {row['ki']}, kd: {row['kd']}"
    slope = f"derivative_of: {row['derivative_of']}, derivative_filter: 4 s"
    limits = f"{{maximum: 60 %, while_limited: {row['while_limited']}}}"
    if row["ki"] == "0":
        return f"{{kind: pid, {gains}, {slope}, output: {{maximum: 90 %}}}}"
    return f"{{kind: pid, {gains}, {slope}, integral: {limits}}}"


def _loop(row: Row, sensor: str, heater: str) -> str:
    below = f", below: {row['below']}" if row["below"] else ""
    rules = {"runaway": f"{{above: 10 K, for: 60 s{below}}}"}
    if row["off"]:
        rules[row["off"]] = "off"
    if row["algorithm"] == "pid" and row["ki"] == "0":
        rules["frozen"] = "off"  # it may rest below the setpoint
    if row["sensor"] in {"max6675", "thermistor"}:
        rules["minimum"] = "6 °C"
    protection = ", ".join(f"{rule}: {text}" for rule, text in rules.items())
    fan = ", fan: fan" if row["fan"] == "yes" else ""
    return (
        f"{{sensor: {sensor}, heater: {heater}{fan}, period: 1 s, algorithm: {_algorithm(row)},"
        f" setpoint: {{initial: 20 °C, minimum: 10 °C, maximum: 70 °C, stored: {row['stored']}}},"
        f" protection: {{{protection}}}}}"
    )


ALGORITHM = ("algorithm", "lead", "hysteresis", "ki", "kd", "derivative_of", "while_limited")


def telling(row: Row) -> Row:
    """Return the choices of a row that its firmware shows: a P controller has no derivative."""
    silent: set[str] = set()
    silent |= {"ki", "kd"} if row["algorithm"] == "on_off" else {"lead", "hysteresis"}
    if row["algorithm"] == "on_off" or row["kd"] == "0":
        silent.add("derivative_of")
    if row["algorithm"] == "on_off" or row["ki"] == "0":
        silent.add("while_limited")
    if row["output"] != "time_proportional":
        silent |= {"minimum_on", "minimum_off"}
    if row["sensor"] != "ds18b20":
        silent.add("bits")
    if row["off"] == "runaway":
        silent.add("below")
    return {choice: value for choice, value in row.items() if choice not in silent}


def variant(row: Row) -> tuple[str, ...]:
    """Return all that is chosen of the algorithm: every combination is wanted, not only pairs."""
    shown = telling(row)
    return tuple(f"{choice}: {shown[choice]}" for choice in ALGORITHM if choice in shown)


def pairs(row: Row) -> frozenset[object]:
    """Return every two choices that meet in a row, and its algorithm."""
    return frozenset({*combinations(sorted(telling(row).items()), 2), variant(row)})


def pairwise(seed: int = 5, pool_size: int = 4000) -> list[Row]:
    """Return few rows in which every two choices meet that can; the same in every run."""
    return fewest(drawn(CHOICES, seed, pool_size, can_be), pairs)


def drawn(
    choices: Mapping[str, tuple[str, ...]], seed: int, count: int, allowed: Callable[[Row], bool]
) -> list[Row]:
    """Return random rows that the language allows."""
    picked = random.Random(seed)  # noqa: S311 - no secret
    rows = (
        {choice: picked.choice(values) for choice, values in choices.items()} for _ in range(count)
    )
    return [row for row in rows if allowed(row)]


def fewest(pool: list[Row], shown: Callable[[Row], frozenset[object]]) -> list[Row]:
    """Return few of the rows that show all that any of them shows."""
    number: dict[object, int] = {}
    masks = [
        sum(1 << number.setdefault(each, len(number)) for each in sorted(shown(row), key=repr))
        for row in pool
    ]
    missing = (1 << len(number)) - 1
    rows: list[Row] = []
    while missing:
        best = max(range(len(pool)), key=lambda index: (masks[index] & missing).bit_count())
        missing &= ~masks[best]
        rows.append(pool[best])
    return rows
