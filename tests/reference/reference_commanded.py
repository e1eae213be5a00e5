"""A loop that a host commands, read in steps of 1/16 K."""

from collections.abc import Iterable
from typing import Any

from heatwright.sim.reference import Record, Reference
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


class Commanded:
    """Feeds temperatures and orders, and collects records."""

    def __init__(self, controller: Controller, setpoint_c: float = 50.0) -> None:
        self.reference = Reference(controller, "air")
        self.setpoint_c = setpoint_c
        self.mode = AUTOMATIC
        self.manual_percent = 0.0
        self.gains = Gains(Single(2), Single(0.5), Single(8))

    @property
    def tuner(self) -> Any:
        return self.reference.steering.tuner

    def feed(self, temperature_c: float) -> Record:
        raw = round(temperature_c * 16)
        assert raw == temperature_c * 16, "not a temperature that the sensor can report"
        return self._step(0, raw)

    def miss(self, status: int = 1) -> Record:
        return self._step(status, 0)

    def feed_all(self, temperatures_c: Iterable[float]) -> list[Record]:
        return [self.feed(temperature_c) for temperature_c in temperatures_c]

    def by_hand(self, percent: float) -> None:
        self.mode, self.manual_percent = MANUAL, percent

    def tune(self, target_c: float, cycles: int | None = None) -> None:
        self.setpoint_c, self.mode = target_c, TUNING
        self.tuner.start(cycles)

    def _step(self, status: int, raw: int) -> Record:
        orders = Orders(self.mode, Single(self.manual_percent), self.gains)
        return self.reference.step(status, raw, Single(self.setpoint_c), orders=orders)
