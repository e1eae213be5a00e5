"""A kettle with keys, whose heater's current is measured, and its machine."""

from rig.avr import whole
from rig.specs import spec_of

from heatwright.sim.faults.world import Site

SPEC = """
heatwright: 1
controller: {name: kettle, board: uno}
sensors:
  water:
    kind: thermistor
    pin: A1
    divider: {pull_up: 4.7 kΩ}
    curve: {resistance: 10 kΩ, at: 25 °C, beta: 3950 K}
    range: 0 °C .. 150 °C
    oversample: 8
  amps: {kind: current, pin: A2, scale: 0.25 V/A}
outputs:
  heater: {HEATER, pin: D3, power: 240 W, supply: 24 V, current: {sensor: amps, CURRENT}}
loops:
  water:
    sensor: water
    heater: heater
    period: 500 ms
    setpoint: {initial: 40 °C, minimum: 30 °C, maximum: 90 °C}
    algorithm: {ALGORITHM}
    protection: {minimum: 3 °C, rise_rate: 10 K/s}
interfaces:
  - {kind: lcd_keypad, loop: water, step: 10 K}
simulation:
  ambient: 20 °C
  plant:
    kind: thermal_network
    nodes: {jug: 1000 J/K}
    links:
      - {between: [jug, ambient], resistance: 1 K/W}
    heat: {heater: jug}
    sense: {water: {node: jug, lag: 2 s}, amps: {of: heater, lag: 20 ms}}
  scenario:
    - {for: 100 s}
"""
KETTLES = {
    "limited": ("kind: pwm, frequency: 976.5625 Hz", "limit: 8 A",
                "kind: pid, kp: 20, ki: 0.1"),
    "tripped": ("kind: digital", "trip: 12 A", "kind: on_off, hysteresis: 1 K"),
}  # fmt: skip
"""Heater, current and algorithm."""


def kettle(name: str) -> Site:
    """Return the machine and its binary."""
    heater, current, algorithm = KETTLES[name]
    text = SPEC.replace("HEATER", heater).replace("CURRENT", current)
    text = text.replace("ALGORITHM", algorithm)
    return Site(spec_of(text).controller, whole(text), "water")
