"""Machines with a MAX31856, and the binaries of their firmware."""

from functools import cache
from pathlib import Path
from tempfile import mkdtemp

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.elf import Elf
from heatwright.spec import Spec, load_text

PINS = {
    "uno": ("D10", "D8", "D12", "D11", "D9"),
    "leonardo": ("D5", "A5", "D8", "D10", "D9"),
    "mega2560": ("D49", "A8", "D17", "D48", "D5"),  # ports L, K and H: beyond the reach of SBI
    "atmega1284p": ("PC0", "PA7", "PB1", "PB2", "PD5"),
}
"""By board: CS, SCK, SDO, SDI, heater."""
HOTTER = {
    "initial: 200 °C, minimum: 20 °C": "initial: 600 °C, minimum: 300 °C",
    "maximum: 250 °C": "maximum: 650 °C",
    "minimum: -30 °C": "minimum: 260 °C",
    "maximum: 285 °C": "maximum: 700 °C",
    "ambient: 20 °C": "ambient: 280 °C",
}


@cache
def spec_of(
    board: str = "uno", *, period: str = "350 ms", clock: str = "", extra: str = ""
) -> Spec:
    """A crucible under PID with this converter."""
    select, sck, out, into, heater = PINS[board]
    wires = f"chip_select: {select}, clock: {sck}, data_in: {into}, data_out: {out}"
    text = f"""
heatwright: 1
controller: {{name: crucible, board: {board}{clock}}}
sensors:
  tip: {{kind: max31856, {wires}{extra}}}
outputs:
  heater: {{kind: pwm, pin: {heater}, frequency: 122 Hz, power: 40 W}}
loops:
  crucible:
    sensor: tip
    heater: heater
    period: {period}
    setpoint: {{initial: 200 °C, minimum: 20 °C, maximum: 250 °C}}
    algorithm: {{kind: pid, kp: 25, ki: 0.4, kd: 60, derivative_filter: 1 s}}
    protection:
      maximum: 285 °C
      minimum: -30 °C
      rise_rate: 20 K/s
      heating: {{rise: 2 K, within: 20 s}}
      runaway: {{above: 15 K, below: 15 K, for: 20 s}}
      stale_after: 2 s
safety: {{watchdog: 1 s}}
simulation:
  ambient: 20 °C
  plant:
    kind: thermal_network
    nodes: {{crucible: 20 J/K}}
    links: [{{between: [crucible, ambient], resistance: 11 K/W}}]
    heat: {{heater: crucible}}
    sense: {{tip: {{node: crucible, lag: 3 s}}}}
  scenario:
    - {{for: 600 s}}
"""
    if "thermocouple: B" in extra:  # below 250 °C it measures nothing
        for usual, hot in HOTTER.items():
            text = text.replace(usual, hot)
    return load_text(text, "crucible.yaml")


@cache
def program(board: str = "uno", *, period: str = "350 ms", clock: str = "", extra: str = "") -> Elf:
    """Its binary, as PlatformIO builds it."""
    folder = Path(mkdtemp(prefix="crucible-"))
    spec = spec_of(board, period=period, clock=clock, extra=extra)
    write(render(plan_firmware(spec)), folder)
    return Elf(build(folder).elf)
