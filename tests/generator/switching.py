"""Firmware that is switched, cooled, measured and shown, of every shape: as matrix for the rest."""

from itertools import combinations

from matrix import PINS, PWM_PINS, Row, drawn, fewest

BOARDS = (
    "uno", "nano", "mega2560", "leonardo", "atmega328p", "atmega2560", "atmega1284p",
    "atmega32", "atmega16",
)  # fmt: skip
CHOICES: dict[str, tuple[str, ...]] = {
    "board": BOARDS,
    "heater": ("digital", "pwm", "time_proportional"),
    "hold": ("", "minimum_on: 40 ms", "minimum_off: 50 ms", "minimum_on: 60 ms, minimum_off: 1 s"),
    "active": ("high", "low"),
    "algorithm": (
        "kind: on_off",
        "kind: pid, kp: 8, ki: 0.05, kd: 20",
        "kind: three_position, dead_band: 2 K",
        "kind: three_position, dead_band: 2 K, hysteresis: 1 K",
        "kind: three_position, dead_band: 2 K, lead: 3 s, lead_filter: 1 s",
    ),
    "autotune": ("", "{}"),
    "cooling": ("", "minimum_on: 1 s", "minimum_off: 2 s"),
    "current": ("", "trip: 4 A", "limit: 3 A", "limit: 3 A, trip: 5 A"),
    "host": ("", "gcode", "modbus"),
    "line": ("baud: 1200, parity: none", "baud: 19200", "baud: 115200, parity: odd, stop_bits: 2"),
    "driver": ("no", "yes"),
    "linuxcnc": ("false", "true"),
    "lost": ("", "master_lost_after: 20 s"),
    "starts": ("enabled", "disabled"),
    "stored": ("false", "true"),
    "leds": ("", "enabled", "heating", "cooling", "warm", "communicating", "fault, fault", "all"),
    "loops": ("1", "2"),
}
"""`hold` is for a digital heater, or for the host's fan."""

MEANINGS = ("enabled", "heating", "cooling", "warm", "communicating", "fault")
LEDS = {
    **dict.fromkeys(("uno", "nano", "leonardo"), ("D4", "D5", "D6", "D7", "D8", "D9")),
    "mega2560": ("D30", "D31", "D32", "D33", "D34", "D35"),
    "atmega328p": ("PD4", "PD5", "PD6", "PD7", "PB0", "PC5"),
    "atmega2560": ("PC0", "PC1", "PC2", "PC3", "PC4", "PC5"),
    **dict.fromkeys(("atmega1284p", "atmega32", "atmega16"),
                    ("PC0", "PC1", "PB0", "PB1", "PB2", "PD6")),
}  # fmt: skip
ANALOG = {
    **dict.fromkeys(("uno", "nano", "leonardo"), "A4"), "mega2560": "A5", "atmega328p": "PC4",
    "atmega2560": "PF2", **dict.fromkeys(("atmega1284p", "atmega32", "atmega16"), "PA5"),
}  # fmt: skip
"""A pin of the ADC for a second loop."""
THERMOMETER = (
    "{{kind: thermistor, pin: {pin}, divider: {{pull_up: 4.7 kΩ}}, oversample: 4, "
    "curve: {{resistance: 100 kΩ, at: 25 °C, beta: 4267 K}}, range: 0 °C .. 300 °C}}"
)
PROTECTION = "maximum: 280 °C, minimum: 5 °C, rise_rate: 20 K/s, frozen: off"


def can_be(row: Row) -> bool:
    """Tell what the language allows, and what means something."""
    cooled = "three_position" in row["algorithm"]
    is_pid, digital = "pid" in row["algorithm"], row["heater"] == "digital"
    served = row["host"] == "modbus"
    return not any((
        is_pid and digital,
        row["autotune"] and not (is_pid and row["host"]),
        row["cooling"] and (not cooled or row["current"]),
        row["current"] and (row["heater"] == "time_proportional" or (digital and row["hold"])),
        "limit" in row["current"] and digital,
        row["hold"] and not (digital or row["host"] == "gcode"),
        not served and (row["driver"] == "yes" or row["linuxcnc"] == "true" or row["lost"]),
        not served and (row["starts"] == "disabled" or row["line"] != CHOICES["line"][0]),
        row["leds"] == "cooling" and not cooled,
        row["leds"] == "communicating" and not served,
        # Too much for its flash.
        row["board"] == "atmega16" and (row["loops"] == "2" or row["host"] == "gcode"),
        row["lost"] and "1200" in row["line"],
    ))  # fmt: skip


def spec_of(row: Row) -> str:
    """Write the spec."""
    heater, second, fan, sensor, other, *_ = PINS[row["board"]]
    if row["heater"] == "pwm":
        heater = PWM_PINS[row["board"]]["pwm16"]
    outputs = {"heater": _heater(row, heater)}
    sensors = {"air": THERMOMETER.format(pin=sensor)}
    if "three_position" in row["algorithm"]:
        more = f", {row['cooling']}" if row["cooling"] else ""
        outputs["cooler"] = f"{{kind: digital, pin: {second}, active: {row['active']}{more}}}"
    if row["current"]:
        sensors["amps"] = f"{{kind: current, pin: {other}, scale: 0.5 V/A, offset: 0.1 V}}"
    if row["host"] == "gcode":
        more = f", {row['hold']}" if row["hold"] else ""
        outputs["blower"] = f"{{kind: digital, pin: {fan}{more}}}"
    loops = {"air": _loop(row)}
    if row["loops"] == "2":
        outputs["hot"] = f"{{kind: digital, pin: {PINS[row['board']][6]}, power: 20 W}}"
        sensors["bed"] = THERMOMETER.format(pin=ANALOG[row["board"]])
        loops["bed"] = (
            "{sensor: bed, heater: hot, period: 2 s, algorithm: {kind: on_off}, protection:"
            " {minimum: 5 °C}, setpoint: {initial: 20 °C, minimum: 10 °C, maximum: 70.5 °C}}"
        )
    lines = [f"heatwright: 1\ncontroller: {{name: shape, board: {row['board']}}}"]
    for section, entries in {"sensors": sensors, "outputs": outputs, "loops": loops}.items():
        lines += [f"{section}:", *(f"  {name}: {text}" for name, text in entries.items())]
    shown = [f"  - {each}" for each in (*_host(row, fan), *_leds(row))]
    return "\n".join([*lines, *(["interfaces:", *shown] if shown else [])]) + "\n"


def _heater(row: Row, pin: str) -> str:
    own = {
        "digital": row["hold"],
        "pwm": "frequency: 100 Hz",
        "time_proportional": "window: 2 s, resolution: 20 ms",
    }[row["heater"]]
    current = f"supply: 12 V, current: {{sensor: amps, {row['current']}}}"
    parts = [f"kind: {row['heater']}", f"pin: {pin}", f"active: {row['active']}", "power: 40 W"]
    parts += [own] * bool(own) + [current] * bool(row["current"])
    return "{" + ", ".join(parts) + "}"


def _loop(row: Row) -> str:
    keys = ["sensor: air", "heater: heater", "period: 500 ms", f"algorithm: {{{row['algorithm']}}}"]
    keys += ["cooler: cooler"] * ("three_position" in row["algorithm"])
    keys += [f"starts: {row['starts']}"] * (row["host"] == "modbus")
    keys += [f"autotune: {row['autotune']}"] * bool(row["autotune"])
    lost = f", {row['lost']}" if row["lost"] else ""
    keys.append(f"protection: {{{PROTECTION}{lost}}}")
    bounds = f"minimum: 10 °C, maximum: 250 °C, stored: {row['stored']}"
    keys.append(f"setpoint: {{initial: 20 °C, {bounds}}}")
    return "{" + ", ".join(keys) + "}"


def _host(row: Row, driver: str) -> list[str]:
    if row["host"] == "gcode":
        return ["{kind: gcode, loops: {T0: air}, fans: {P0: blower}}"]
    if row["host"] != "modbus":
        return []
    wire = f", driver_enable: {driver}" if row["driver"] == "yes" else ""
    return [f"{{kind: modbus_rtu, {row['line']}{wire}, linuxcnc: {row['linuxcnc']}}}"]


def _leds(row: Row) -> list[str]:
    meanings = row["leds"].split(", ") if row["leds"] else []
    if meanings == ["all"]:
        meanings = [each for each in MEANINGS if _means(row, each)][:5]
    leds = ", ".join(
        f"{pin}: {each}" for pin, each in zip(LEDS[row["board"]], meanings, strict=False)
    )
    if not leds:
        return []
    return [f"{{kind: indicators, loop: air, active: {row['active']}, leds: {{{leds}}}}}"]


def _means(row: Row, meaning: str) -> bool:
    if meaning == "cooling":
        return "three_position" in row["algorithm"]
    return meaning != "communicating" or row["host"] == "modbus"


def pairs(row: Row) -> frozenset[object]:
    """Return every two choices that meet in a row."""
    return frozenset(combinations(sorted(row.items()), 2))


def telling(row: Row) -> Row:
    """Take the first of what means nothing in a row: a loop without a master has no line."""
    served, cooled = row["host"] == "modbus", "three_position" in row["algorithm"]
    silent: set[str] = set()
    if not served:
        silent |= {"driver", "linuxcnc", "lost", "starts", "line"}
    if not cooled or row["current"]:
        silent.add("cooling")
    if row["heater"] == "time_proportional":
        silent.add("current")
    if row["host"] != "gcode" and (row["heater"] != "digital" or row["current"]):
        silent.add("hold")
    if "pid" not in row["algorithm"] or not row["host"]:
        silent.add("autotune")
    return {choice: CHOICES[choice][0] if choice in silent else row[choice] for choice in row}


def pairwise(seed: int = 11, pool_size: int = 8_000) -> list[Row]:
    """Return few rows in which every two choices meet that can; the same in every run."""
    rows = [telling(row) for row in drawn(CHOICES, seed, pool_size, lambda _: True)]
    return fewest([row for row in rows if can_be(row)], pairs)
