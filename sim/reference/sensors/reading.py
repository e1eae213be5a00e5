"""The reading of a step, and the mean that the control uses (docs/control.md, "Moving average")."""

from collections.abc import Iterator
from importlib import import_module
from typing import NamedTuple

from heatwright.sim.reference.numbers import ZERO, Kept, Single, Value
from heatwright.spec import Controller
from heatwright.spec.registry import module_of

RAW_WIDTH = "i2"
"""Type of the sensor's raw number, unless its kind has another."""
MOST_MISSING = 255
"""Maximum of the count of missing readings: `stale_after` cannot be longer."""


class Seen(NamedTuple):
    """A temperature, and that of the reading before (the same if there was none)."""

    temperature_c: Single
    last_c: Single


class Average:
    """The mean of the last readings, in a ring buffer.

    window -- the readings; turn -- the place of the next one; is_empty -- before the first reading.
    """

    def __init__(self, number: int) -> None:
        """Start with an empty window."""
        self.window: list[Value] = [ZERO] * number
        self.turn: Value = 0
        self.is_empty = True
        self._share = Single(1 / number)

    def take(self, reading_c: Single, *, anew: bool) -> Single:
        """Add a reading, if `anew` to an empty window, and return the mean."""
        if anew or self.is_empty:
            self.window = [reading_c] * len(self.window)
            self.is_empty = False
        self.window[self.turn] = reading_c
        self.turn = (self.turn + 1) % len(self.window)
        total = self.window[0]
        for other in self.window[1:]:
            total = total + other
        return Single(total * self._share)


class Readings(Kept):
    """A sensor's temperature over the steps."""

    def __init__(self, controller: Controller, name: str) -> None:
        """Start without a reading; name -- the sensor's name."""
        sensor = controller.thermometers[name]
        kind = import_module(module_of("sensor", "reference", sensor.kind))
        self._convert = kind.converter(sensor, controller.board)
        self.average = Average(sensor.moving_average) if sensor.moving_average > 1 else None
        """Computes the mean that the control uses, if it is of several readings."""
        self.raw_width: str = getattr(kind, "RAW", RAW_WIDTH)
        self.keep(
            ("reading_status", "u1", "_status"),
            ("reading_raw", self.raw_width, "_raw"),
            ("temperature_c", "f4", "mean.temperature_c"),
            *[("reading_c", "f4", "single.temperature_c")] * (self.average is not None),
            ("missing", "u1", "missing"),
            ("has_reading", "u1", "_has_reading"),
        )
        self._status = self._raw = 0
        self.missing = 0
        """Steps without a valid reading in a row."""
        self._has_reading = 0
        self.gap = 1
        """Periods since the valid reading before."""
        self.single = Seen(ZERO, ZERO)
        """The single reading, which the rules check."""
        self.mean = Seen(ZERO, ZERO)
        """The temperature that the control uses."""

    def take(self, status: int, raw: int, *, anew: bool = False) -> None:
        """Process a reading; `anew`: earlier readings no longer count."""
        self.gap = self.missing + 1 if self._has_reading else 1
        self._status, self._raw = status, raw
        if status:
            self.missing = min(self.missing + 1, MOST_MISSING)
            self.single, self.mean = _kept(self.single), _kept(self.mean)
            return
        reading_c = self._convert(raw)
        mean_c = self.average.take(reading_c, anew=anew) if self.average else reading_c
        self.single = self._after(self.single, reading_c)
        self.mean = self._after(self.mean, mean_c)
        self.missing = 0
        self._has_reading = 1

    def resume(self, values: Iterator[Value]) -> None:
        """Take over the values of `members`; an average's window is not among them."""
        super().resume(values)
        if self.average is None:
            self.single = self.mean

    def _after(self, before: Seen, temperature_c: Single) -> Seen:
        return Seen(temperature_c, before.temperature_c if self._has_reading else temperature_c)


def _kept(seen: Seen) -> Seen:
    return Seen(seen.temperature_c, seen.temperature_c)
