"""A loop that a host commands, read in steps of 1/16 K."""

from typing import Any

from player import Player

from heatwright.sim.reference import Record
from heatwright.sim.reference.inputs import AUTOMATIC, MANUAL, TUNING, Gains, Orders
from heatwright.sim.reference.numbers import Single
from heatwright.spec import Controller, load_text

TEXT = """
heatwright: 1
controller: {name: box, board: uno}
sensors:
  air: {kind: ds18b20, pin: A1}
outputs:
  heater: {kind: pwm, pin: D3, frequency: 490 Hz, power: 240 W}
loops:
  air:
    sensor: air
    heater: heater
    period: 1 s
    setpoint: {initial: 0 °C, minimum: 0 °C, maximum: 100 °C}
    algorithm: {kind: pid, kp: 2, ki: 0.5, kd: 8, ALGORITHM}
    LOOP
    protection: {maximum: 120 °C, PROTECTION}
interfaces:
  - {kind: gcode, loops: {T0: air}}
"""


def controller_of(
    algorithm: str = "derivative_filter: 0 s", loop: str = "", protection: str = "frozen: off"
) -> Controller:
    text = TEXT.replace("ALGORITHM", algorithm).replace("LOOP", loop or "autotune: {}")
    return load_text(text.replace("PROTECTION", protection), "box.yaml").controller


class Commanded(Player):
    """Feeds temperatures and orders, and collects records."""

    def __init__(self, controller: Controller, setpoint_c: float = 50.0) -> None:
        super().__init__(controller, setpoint_c=setpoint_c)
        self.mode = AUTOMATIC
        self.manual_percent = 0.0
        self.set_gains(2, 0.5, 8)

    @property
    def tuner(self) -> Any:
        return self.reference.steering.tuner

    def set_gains(self, kp: float, ki: float, kd: float) -> None:
        self.gains: Gains | None = Gains(Single(kp), Single(ki), Single(kd))

    def by_hand(self, percent: float) -> None:
        self.mode, self.manual_percent = MANUAL, percent

    def tune(self, target_c: float, cycles: int | None = None) -> None:
        self.setpoint_c, self.mode = target_c, TUNING
        self.tuner.start(cycles)

    def swing(self) -> list[Record]:
        """Once up at one slope and down at another."""
        return self.ramp(75, 83, 2) + self.ramp(85, 74, -1)

    def step(self, status: int, raw: int, **said: Any) -> Record:
        orders = Orders(self.mode, Single(self.manual_percent), self.gains)
        return super().step(status, raw, orders=orders, **said)
