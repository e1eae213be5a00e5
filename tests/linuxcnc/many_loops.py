"""A spec with several loops whose names are as long as names may be, and what is made of it."""

from collections.abc import Mapping

from rig.specs import files_of

LONGEST = 24
MOST_LOOPS = 8
"""Channels of the ATmega2560's ADC that the simulation knows."""

HEAD = """
heatwright: 1
controller: {{name: {name}, title: '{title}', board: mega2560}}
safety: {{watchdog: 1 s}}
interfaces:
  - {{kind: modbus_rtu, address: 247, baud: {baud}, parity: none, linuxcnc: {linuxcnc}}}
"""
SENSOR = """
  t{n}: {{kind: thermistor, pin: A{n}, divider: {{pull_up: 4.7 kΩ}},
    curve: {{resistance: 10 kΩ, at: 25 °C, beta: 3950 K}}, range: -15 °C .. 110 °C}}
"""
OUTPUT = "  h{n}: {{kind: digital, pin: D{pin}, power: 50 W}}\n"
LOOP = """
  {name}:
    sensor: t{n}
    heater: h{n}
    period: 500 ms
    setpoint: {{initial: 25 °C, minimum: -5 °C, maximum: 80 °C}}
    algorithm: {{kind: on_off, hysteresis: 1 K}}
    protection: {{maximum: 95 °C, minimum: -10 °C, rise_rate: 5 K/s, stale_after: 3 s,
      heating: {{rise: 2 K, within: 2 min}}, runaway: {{above: 8 K, for: 2 min}}}}
"""


def loop_name(number: int) -> str:
    return f"loop_{number}_" + "x" * (LONGEST - len(f"loop_{number}_"))


def many_loops(
    loops: int = MOST_LOOPS, *, name: str = "c" * LONGEST, title: str = "Many", baud: int = 19200,
    linuxcnc: bool = True,
) -> str:  # fmt: skip
    numbers = range(loops)
    text = HEAD.format(name=name, title=title, baud=baud, linuxcnc=str(linuxcnc).lower())
    text += "sensors:\n" + "".join(SENSOR.format(n=n) for n in numbers)
    text += "outputs:\n" + "".join(OUTPUT.format(n=n, pin=22 + n) for n in numbers)
    return text + "loops:\n" + "".join(LOOP.format(n=n, name=loop_name(n)) for n in numbers)


def linuxcnc_files(spec: str) -> dict[str, str]:
    """Return what is generated for LinuxCNC, by its name in a configuration's folder."""
    return of_linuxcnc(files_of(spec))


def of_linuxcnc(files: Mapping[str, str]) -> dict[str, str]:
    folder = "linuxcnc/"
    return {
        path.removeprefix(folder): text for path, text in files.items() if path.startswith(folder)
    }
