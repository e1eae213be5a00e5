"""Firmware that a Modbus master commands, of every shape: what matrix is for the rest."""

from itertools import combinations

from matrix import Row, drawn, fewest

CHOICES: dict[str, tuple[str, ...]] = {
    "board": (
        "uno", "nano", "mega2560", "leonardo", "atmega328p", "atmega2560", "atmega1284p",
        "atmega32", "atmega16",
    ),
    "form": (
        "parity: even", "parity: odd", "parity: none", "parity: none, stop_bits: 1",
        "parity: even, stop_bits: 2",
    ),
    "baud": ("1200", "9600", "19200", "57600", "115200"),
    "driver": ("no", "yes"),
    "loops": ("1", "2"),
    "heater": ("digital", "pwm", "time_proportional"),
    "algorithm": ("on_off", "pid", "three_position"),
    "law": ("", "hysteresis: 0.5 K", "lead: 3 s, lead_filter: 1 s",
            "hysteresis: 0.5 K, lead: 3 s, lead_filter: 1 s"),
    "autotune": ("", "{}", "{cycles: 3}"),
    "current": ("", "limit: 2 A", "trip: 5 A", "limit: 2 A, trip: 5 A"),
    "minimum": ("", "minimum_on: 200 ms", "minimum_off: 300 ms"),
    "starts": ("enabled", "disabled"),
    "stored": ("false", "true"),
    "lost": ("", "10 s"),
    "leds": ("", "enabled", "heating, cooling", "warm, communicating, fault"),
    "linuxcnc": ("false", "true"),
}  # fmt: skip

# Three pins of the ADC; heaters, cooler, driver, three LEDs.
WIRES = {
    **dict.fromkeys(("uno", "nano"),
                    (("A1", "A3", "A4"), ("D3", "D4", "D5", "D2", "D6", "D7", "D8"))),
    "leonardo": (("A1", "A3", "A4"), ("D3", "D4", "D5", "D2", "D6", "D7", "D8")),
    "mega2560": (("A1", "A9", "A4"), ("D22", "D41", "D42", "D2", "D25", "D26", "D27")),
    "atmega328p": (("PC1", "PC3", "PC4"), ("PD3", "PD4", "PD5", "PD2", "PD6", "PD7", "PB0")),
    "atmega2560": (("PF1", "PK3", "PF2"), ("PA0", "PH1", "PJ6", "PL2", "PA1", "PA2", "PA3")),
    **dict.fromkeys(("atmega1284p", "atmega32", "atmega16"),
                    (("PA1", "PA3", "PA4"), ("PB0", "PB1", "PB2", "PD2", "PD6", "PD7", "PB3"))),
}  # fmt: skip
SENSOR = (
    "{{kind: thermistor, pin: {pin}, divider: {{pull_up: 4.7 kΩ}}, oversample: 4, "
    "curve: {{resistance: 100 kΩ, at: 25 °C, beta: 4267 K}}, range: -20 °C .. 300 °C}}"
)
PROTECTION = "maximum: 280 °C, minimum: -15 °C, rise_rate: 20 K/s, frozen: off"


def can_be(row: Row) -> bool:
    """Tell what the language allows, and what 16 KB hold."""
    pid, heater = row["algorithm"] == "pid", row["heater"]
    refused = (
        pid and (heater == "digital" or row["law"] != ""),
        row["autotune"] and not pid,
        row["current"] and (heater == "time_proportional" or row["minimum"] != ""),
        "limit" in row["current"] and heater != "pwm",
        row["minimum"] and heater != "digital",
        "cooling" in row["leds"] and row["algorithm"] != "three_position",
        row["board"] == "atmega16" and row["autotune"] and row["loops"] == "2",
    )
    return not any(refused)


def spec_of(row: Row) -> str:
    """Write the spec."""
    (first, second, third), (heater, bed, cooler, driver, *lights) = WIRES[row["board"]]
    sensors = {"air": SENSOR.format(pin=first)}
    outputs = {"heater": _heater(row, heater)}
    loops = {"air": _loop(row)}
    if row["current"]:
        sensors["shunt"] = f"{{kind: current, pin: {third}, scale: 0.2 V/A}}"
    if row["algorithm"] == "three_position":
        outputs["blower"] = f"{{kind: digital, pin: {cooler}}}"
    if row["loops"] == "2":
        sensors["bed"] = SENSOR.format(pin=second)
        outputs["hot_bed"] = f"{{kind: digital, pin: {bed}, power: 100 W}}"
        loops["bed"] = (
            "{sensor: bed, heater: hot_bed, period: 1 s, algorithm: {kind: on_off},"
            f" setpoint: {{initial: 20 °C, minimum: 10 °C, maximum: 70.5 °C}},"
            f" protection: {{{PROTECTION}}}}}"
        )
    lines = [f"heatwright: 1\ncontroller: {{name: shape, board: {row['board']}}}"]
    for section, entries in {"sensors": sensors, "outputs": outputs, "loops": loops}.items():
        lines += [f"{section}:", *(f"  {name}: {text}" for name, text in entries.items())]
    return "\n".join([*lines, "interfaces:", *_interfaces(row, driver, lights)]) + "\n"


def _heater(row: Row, pin: str) -> str:
    more = {
        "pwm": ", frequency: 100 Hz, supply: 24 V",
        "time_proportional": ", window: 2 s, resolution: 20 ms",
        "digital": ", supply: 24 V",
    }[row["heater"]]
    current = f", current: {{sensor: shunt, {row['current']}}}" if row["current"] else ""
    minimum = f", {row['minimum']}" if row["minimum"] else ""
    return f"{{kind: {row['heater']}, pin: {pin}, power: 80 W{more}{current}{minimum}}}"


def _loop(row: Row) -> str:
    cooler = ", cooler: blower" if row["algorithm"] == "three_position" else ""
    autotune = f", autotune: {row['autotune']}" if row["autotune"] else ""
    lost = f", master_lost_after: {row['lost']}" if row["lost"] else ""
    return (
        f"{{sensor: air, heater: heater{cooler}, period: 500 ms, starts: {row['starts']},"
        f" algorithm: {_algorithm(row)}{autotune}, setpoint: {{initial: 20 °C, minimum: -5 °C,"
        f" maximum: 250 °C, stored: {row['stored']}}}, protection: {{{PROTECTION}{lost}}}}}"
    )


def _algorithm(row: Row) -> str:
    if row["algorithm"] == "pid":
        return "{kind: pid, kp: 8, ki: 0.3, kd: 30, derivative_filter: 4 s}"
    band = "dead_band: 2 K, " if row["algorithm"] == "three_position" else ""
    return f"{{kind: {row['algorithm']}, {band}{row['law']}}}".replace(", }", "}")


def _interfaces(row: Row, driver: str, lights: list[str]) -> list[str]:
    enable = f", driver_enable: {driver}" if row["driver"] == "yes" else ""
    lines = [
        f"  - {{kind: modbus_rtu, baud: {row['baud']}, {row['form']}, address: 247{enable},"
        f" linuxcnc: {row['linuxcnc']}}}"
    ]
    if row["leds"]:
        leds = zip(lights, row["leds"].split(", "), strict=False)
        shown = ", ".join(f"{pin}: {meaning}" for pin, meaning in leds)
        lines.append(f"  - {{kind: indicators, loop: air, leds: {{{shown}}}}}")
    return lines


def pairs(row: Row) -> frozenset[object]:
    """Return every two choices that meet in a row."""
    return frozenset(combinations(sorted(row.items()), 2))


def pairwise(seed: int = 11) -> list[Row]:
    """Return few rows in which every two choices meet that can; the same in every run."""
    return fewest(drawn(CHOICES, seed, 6000, can_be), pairs)
