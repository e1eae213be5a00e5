"""A monitor: a sensor that controls no loop, checked in a loop's step (docs/control.md)."""

from collections.abc import Iterator

from heatwright.sim.reference.numbers import Member, Single, Value, steps
from heatwright.sim.reference.sensors.reading import Readings
from heatwright.spec import Controller, Loop

MONITOR_LIMIT = 27


class MonitorModel:
    """The state of a monitor, and its check.

    members -- its members, without the name of the monitor.
    """

    def __init__(self, controller: Controller, name: str, loop: Loop) -> None:
        """Derive the constants; loop -- the loop in whose steps the monitor is checked."""
        spec = controller.monitors[name]
        self._readings = Readings(controller, spec.sensor)
        self.average = self._readings.average
        self._warning_c = Single(spec.warning_c)
        self._end_c = Single(spec.warning_c - spec.hysteresis_k)
        self._limit_c = Single(spec.limit_c)
        self._stale = steps(spec.stale_after_s, loop)
        self._warns = 0
        self.members: tuple[Member, ...] = (*self._readings.members, ("warns", "u1"))

    @property
    def temperature_c(self) -> Single:
        """The last valid reading; 0 before the first."""
        return self._readings.single.temperature_c

    def step(self, status: int, raw: int) -> int:
        """Process a reading and return the code of the fault, 0 for none."""
        self._readings.take(status, raw)
        if status:
            return status if self._readings.missing >= self._stale else 0
        if self.temperature_c >= self._warning_c:
            self._warns = 1
        elif self.temperature_c <= self._end_c:
            self._warns = 0
        return MONITOR_LIMIT if self.temperature_c >= self._limit_c else 0

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""
        return (*self._readings.values(), self._warns)

    def resume(self, values: Iterator[Value]) -> None:
        """Take over the next values, one for each of `members`."""
        self._readings.resume(values)
        self._warns = next(values)
