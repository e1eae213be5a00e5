"""A nozzle under a master: heater with measured current, cooler, three positions."""

from typing import Any

from player import Player

from heatwright.sim.reference import Record
from heatwright.sim.reference.inputs import Orders
from heatwright.spec import Controller, load_text

TEXT = """
heatwright: 1
controller: {name: box, board: mega2560}
sensors:
  nozzle: {kind: ds18b20, pin: A2}
  current: {kind: current, pin: A1, scale: 0.2 V/A, oversample: 4}
outputs:
  heater:
    {kind: pwm, pin: D5, frequency: 1 kHz, power: 100 W, supply: 50 V, current: CURRENT}
  cooler: {kind: digital, pin: D22}
loops:
  nozzle:
    sensor: nozzle
    heater: heater
    cooler: cooler
    period: 1 s
    starts: disabled
    setpoint: {initial: 50 °C, minimum: 0 °C, maximum: 100 °C}
    algorithm: {kind: three_position, dead_band: 2 K}
    protection:
      maximum: 120 °C
      minimum: -5 °C
      rise_rate: 100 K/s
      heating: off
      runaway: off
      frozen: off
      rising_while_off: off
      master_lost_after: 5 s
interfaces:
  - {kind: modbus_rtu}
"""
LIMIT = "{sensor: current, limit: 2.5 A}"


def controller_of(current: str = LIMIT) -> Controller:
    return load_text(TEXT.replace("CURRENT", current), "box.yaml").controller


STEP_A = 5 / 1024 / 0.2


def raw_of(amperes: float) -> int:
    """The sum of four codes in whose middle a current lies most nearly."""
    return round(4 * (amperes / STEP_A - 0.5))


class Nozzle(Player):
    """Feeds temperatures and currents, and collects records."""

    def __init__(self, controller: Controller | None = None) -> None:
        super().__init__(controller or controller_of(), "nozzle")
        self.enabled = 1
        self.ohm = 25.0
        """Of the heater at 50 V; what it draws follows from the last duty."""
        self.amperes: float | None = None

    def step(self, status: int, raw: int, **said: Any) -> Record:
        share = float(self.reference.duty_percent) / 100
        amperes = 50.0 / self.ohm * share if self.amperes is None else self.amperes
        wanted = Orders(enabled=self.enabled, current_raw=max(0, raw_of(amperes)), **said)
        return super().step(status, raw, orders=wanted)
