"""Firmware with programs, displays, logs and a relay, of every shape: as matrix for the rest."""

from itertools import combinations

from matrix import PINS, PWM_PINS, Row, drawn, fewest

BOARDS = (
    "uno", "nano", "mega2560", "leonardo", "atmega328p", "atmega2560", "atmega1284p", "atmega32",
)  # fmt: skip
CHOICES: dict[str, tuple[str, ...]] = {
    "board": BOARDS,
    "display": ("", "nextion", "keys", "both"),
    "programs": ("no", "yes"),
    "room": ("", "points: 3, places: 1", "points: 5, places: 3"),
    "hold_back": ("", "hold_back: {within: 5 K, limit: 10 min}", "hold_back: off"),
    "after": (
        "", "{resume_within: 30 K}", "{resume_within: 30 K, otherwise: pause}",
        "{otherwise: pause}",
    ),
    "at_end": ("off", "hold"),
    "stored": ("none", "one", "two"),
    "algorithm": (
        "kind: on_off",
        "kind: pid, kp: 8, ki: 0.05",
        "kind: pid, kp: 8, ki: 0.05, feed_forward: 90",
        "kind: pid, kp: 8, ki: 0.05, kd: 20, derivative_filter: 4 s, dead_band: 0.2 K, "
        "feed_forward: 90",
        "kind: three_position, dead_band: 0.8 K",
    ),
    "heater": ("digital", "pwm", "burst", "spread"),
    "sensor": ("max31856", "max31856, selectable: [S, K, R]", "ds18b20"),
    "average": ("1", "5"),
    "adjustable": ("false", "true"),
    "relay": ("", "alone", "with contact"),
    "log": ("", "keep: ram, entries: 20", "keep: eeprom, entries: 10, every: 1 h"),
    "starts": ("", "starts: enabled", "starts: disabled"),
    "remembered": ("false", "true"),
    "loops": ("1", "2"),
    "runaway": ("", "runaway: off"),
    "master": ("no", "yes"),
    "leds": ("no", "yes"),
}  # fmt: skip
"""Of `log` a part: it takes the serial port that is left."""

SHIELDED = {"uno", "leonardo", "mega2560"}
PORTS = {"mega2560": 4, "atmega2560": 4, "atmega1284p": 2}
# Relay, its contact, an LED.
WIRES = {
    **dict.fromkeys(("uno", "nano", "leonardo"), ("D3", "D11", "A0")),
    "mega2560": ("D27", "D28", "D29"),
    "atmega328p": ("PD3", "PD4", "PD5"),
    "atmega2560": ("PA2", "PA3", "PA4"),
    **dict.fromkeys(("atmega1284p", "atmega32"), ("PB0", "PB1", "PB2")),
}
SEGMENTS = (
    "[{to: 60 °C, over: 10 min}, {to: 80 °C, at: 30.5 K/h}, {hold: 1 min}]",
    "[{to: 90 °C, at: as fast as possible}, {hold: until operator}, {to: 30 °C, over: 31 d}]",
)


def ports(row: Row) -> int:
    """Count the serial ports that a row takes."""
    return (row["display"] in {"nextion", "both"}) + bool(row["log"]) + (row["master"] == "yes")


def can_be(row: Row) -> bool:
    """Tell what the language allows, and what fits the chip."""
    programmed, shown = row["programs"] == "yes", row["display"]
    touched = shown in {"nextion", "both"}
    is_pid, digital = "pid" in row["algorithm"], row["heater"] == "digital"
    menu = touched or (shown == "keys" and programmed)
    return not any((
        is_pid == digital,
        shown in {"keys", "both"} and row["board"] not in SHIELDED,
        shown in {"keys", "both"} and row["heater"] == "pwm" and row["board"] != "mega2560",
        shown in {"keys", "both"} and row["leds"] == "yes",
        programmed and (not shown or row["master"] == "yes"),
        ports(row) > PORTS.get(row["board"], 1),
        not menu and (row["adjustable"] == "true" or "selectable" in row["sensor"]),
        "feed_forward" in row["algorithm"] and not programmed,
        "off" in row["hold_back"] and not row["runaway"],
        "disabled" in row["starts"] and not (programmed or touched or row["master"] == "yes"),
        row["loops"] == "2" and row["board"] == "atmega32",
        touched and row["board"] not in {*PORTS, "leonardo"},  # too little RAM
        touched and row["board"] == "leonardo" and programmed and "points: 3" not in row["room"],
        shown == "both" and row["board"] == "leonardo" and programmed,
    ))  # fmt: skip


def telling(row: Row) -> Row:
    """Take the first of what means nothing in a row."""
    silent: set[str] = set()
    if row["programs"] == "no":
        silent |= {"room", "hold_back", "after", "at_end", "stored"}
    if not row["log"]:
        silent.add("log")
    return {choice: CHOICES[choice][0] if choice in silent else row[choice] for choice in row}


def spec_of(row: Row) -> str:
    """Write the spec."""
    heater, second, fan, _, other, *_ = PINS[row["board"]]
    relay, contact, _ = WIRES[row["board"]]
    if row["heater"] == "pwm":
        heater = PWM_PINS[row["board"]]["pwm16"]
    outputs = {"heater": _heater(row, heater)}
    sensors = {"air": _sensor(row)}
    loops = {"air": _loop(row)}
    if "three_position" in row["algorithm"]:
        outputs["cooler"] = f"{{kind: digital, pin: {second}}}"
    if row["loops"] == "2":
        outputs["hot"] = f"{{kind: digital, pin: {fan}, power: 20 W}}"
        scale = "scale: 10 mV/K, offset: 0.5 V, range: -30 °C .. 120 °C"
        sensors["bed"] = f"{{kind: analog, pin: {other}, {scale}}}"
        loops["bed"] = (
            "{sensor: bed, heater: hot, period: 2 s, algorithm: {kind: on_off}, "
            "setpoint: {initial: 20 °C, minimum: 10 °C, maximum: 70.5 °C}}"
        )
    lines = [f"heatwright: 1\ncontroller: {{name: shape, board: {row['board']}}}"]
    if row["relay"]:
        outputs["relay"] = f"{{kind: digital, pin: {relay}}}"
        more = f", relay_feedback: {contact}" if "contact" in row["relay"] else ""
        lines.append(f"safety: {{relay: relay{more}}}")
    for section, entries in {"sensors": sensors, "outputs": outputs, "loops": loops}.items():
        lines += [f"{section}:", *(f"  {name}: {text}" for name, text in entries.items())]
    lines += _programs(row) if row["programs"] == "yes" else []
    shown = [f"  - {each}" for each in _interfaces(row)]
    return "\n".join([*lines, *(["interfaces:", *shown] if shown else [])]) + "\n"


def _sensor(row: Row) -> str:
    *_, pin, _, clock, data, told = PINS[row["board"]]
    wires = f"pin: {pin}"
    if "max31856" in row["sensor"]:
        wires = f"chip_select: {pin}, clock: {clock}, data_in: {told}, data_out: {data}"
    return f"{{kind: {row['sensor']}, {wires}, moving_average: {row['average']}}}"


def _heater(row: Row, pin: str) -> str:
    own = {
        "digital": "kind: digital, minimum_on: 40 ms",
        "pwm": "kind: pwm, frequency: 100 Hz",
        "burst": "kind: time_proportional, window: 2 s, resolution: 20 ms, minimum_off: 60 ms",
        "spread": "kind: time_proportional, window: 2 s, resolution: 20 ms, distribution: spread",
    }[row["heater"]]
    return f"{{{own}, pin: {pin}, active: low, power: 484 W}}"


def _loop(row: Row) -> str:
    keys = ["sensor: air", "heater: heater", "period: 1 s", f"algorithm: {{{row['algorithm']}}}"]
    keys += ["cooler: cooler"] * ("three_position" in row["algorithm"])
    keys += [row["starts"]] * bool(row["starts"])
    rules = f"maximum: 110 °C, maximum_adjustable: {row['adjustable']}"
    keys.append(f"protection: {{{rules}{', ' * bool(row['runaway'])}{row['runaway']}}}")
    bounds = f"minimum: 10 °C, maximum: 95 °C, stored: {row['remembered']}"
    keys.append(f"setpoint: {{initial: 20 °C, {bounds}}}")
    return "{" + ", ".join(keys) + "}"


def _programs(row: Row) -> list[str]:
    keys = ["loop: air", "save_every: 1 h", f"at_end: {row['at_end']}"]
    keys += [row["hold_back"], *row["room"].split(", ")]
    keys += [f"after_power_loss: {row['after']}"] * bool(row["after"])
    count = {"none": 0, "one": 1, "two": 2}[row["stored"]]
    if "places: 1" in row["room"]:
        count = min(count, 1)
    programs = [
        f"{{name: no {number}, segments: {segments}}}"
        for number, segments in enumerate(SEGMENTS[:count])
    ]
    keys += [f"stored: [{', '.join(programs)}]"] * bool(programs)
    return ["programs: {" + ", ".join(key for key in keys if key) + "}"]


def _interfaces(row: Row) -> list[str]:
    found: list[str] = []
    port = 0
    if row["master"] == "yes":
        found.append("{kind: modbus_rtu}")
        port += 1
    if row["display"] in {"nextion", "both"}:
        found.append(f"{{kind: nextion, loop: air, port: {port}}}")
        port += 1
    if row["log"]:
        found.append(f"{{kind: serial_log, loop: air, port: {port}, {row['log']}}}")
    if row["display"] in {"keys", "both"}:
        found.append("{kind: lcd_keypad, loop: air}")
    if row["leds"] == "yes":
        *_, led = WIRES[row["board"]]
        found.append(f"{{kind: indicators, loop: air, leds: {{{led}: enabled}}}}")
    return found


def pairs(row: Row) -> frozenset[object]:
    """Return every two choices that meet in a row."""
    return frozenset(combinations(sorted(row.items()), 2))


def pairwise(seed: int = 13, pool_size: int = 60_000) -> list[Row]:
    """Return few rows in which every two choices meet that can; the same in every run."""
    rows = [telling(row) for row in drawn(CHOICES, seed, pool_size, lambda _: True)]
    return fewest([row for row in rows if can_be(row)], pairs)
