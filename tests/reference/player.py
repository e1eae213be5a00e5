"""Feeds a reference model with temperatures and collects its records."""

from collections.abc import Iterable

from heatwright.sim.reference import Record, Reference
from heatwright.sim.reference.numbers import Single
from heatwright.spec import Controller


class Player:
    def __init__(self, controller: Controller) -> None:
        self.reference = Reference(controller, "air")
        self.setpoint_c = 50.0

    def feed(self, temperature_c: float, *, acknowledge: bool = False) -> Record:
        raw = round(temperature_c * 16)
        assert raw == temperature_c * 16, "not a temperature that the sensor can report"
        return self.reference.step(0, raw, Single(self.setpoint_c), acknowledge=acknowledge)

    def miss(self, status: int = 1) -> Record:
        return self.reference.step(status, 0, Single(self.setpoint_c))

    def feed_all(self, temperatures_c: Iterable[float]) -> list[Record]:
        return [self.feed(temperature_c) for temperature_c in temperatures_c]

    def steps_until_fault(self, temperatures_c: Iterable[float]) -> int | None:
        """The number, from 1, of the first step after which a fault is latched."""
        for number, temperature_c in enumerate(temperatures_c, 1):
            if self.feed(temperature_c)["fault.code"]:
                return number
        return None
