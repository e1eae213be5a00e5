"""Feeds a reference model with temperatures and collects its records."""

from collections.abc import Iterable
from typing import Any

from heatwright.sim.reference import Record, Reference
from heatwright.sim.reference.numbers import Single
from heatwright.spec import Controller


class Player:
    """A loop of a model that keeps its last record; its sensor has so many steps in a kelvin."""

    steps_per_k = 16

    def __init__(self, controller: Controller, loop: str = "air", setpoint_c: float = 50.0) -> None:
        self.reference = Reference(controller, loop)
        self.setpoint_c = setpoint_c
        self.record: Record = {}

    def feed(self, temperature_c: float, status: int = 0, **said: Any) -> Record:
        raw = round(temperature_c * self.steps_per_k)
        assert raw == temperature_c * self.steps_per_k, "no temperature that the sensor can report"
        return self.step(status, 0 if status else raw, **said)

    def miss(self, status: int = 1) -> Record:
        return self.step(status, 0)

    def feed_all(self, temperatures_c: Iterable[float]) -> list[Record]:
        return [self.feed(temperature_c) for temperature_c in temperatures_c]

    def saw(self, centre_c: float, count: int) -> list[Record]:
        """Feed a reading that moves by one sensor step, so that it is not frozen."""
        return self.feed_all(centre_c + number % 2 / 16 for number in range(count))

    def ramp(self, first_c: float, last_c: float, by_k: float) -> list[Record]:
        return self.feed_all(
            first_c + n * by_k for n in range(round((last_c - first_c) / by_k) + 1)
        )

    def step(self, status: int, raw: int, **said: Any) -> Record:
        self.record = self.reference.step(status, raw, Single(self.setpoint_c), **said)
        return self.record
