"""The measured figures, each with its limit."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

BUTTON_MS = 50.0
"""A key must react at once: this is half of the tenth of a second that a person notices."""
JITTER_US = 1000.0
"""A thousandth of the usual control period of 1 s. It is allowed once per loop, as a loop's step
may come after those of all others."""
BUSY_US = 100.0
"""No wait may be longer than two instructions of the display."""
SLOT_US = 70.0
"""Longest time with interrupts off in a slot of the 1-Wire bus, which lasts at least 60 µs."""


@dataclass(frozen=True)
class Figure:
    """The worst measured value of a quantity, its limit, and details.

    what -- the quantity, in words; unit -- ms, µs or bytes; worst -- None: it could not be
    measured, which fails; where -- the function with the worst value; details -- further numbers.
    """

    what: str
    unit: str
    worst: float | None
    limit: float
    where: str | None = None
    details: Mapping[str, float] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """Whether the figure is within its limit."""
        return self.worst is not None and self.worst <= self.limit

    def as_json(self) -> dict[str, Any]:
        """Return the figure as JSON data, in the unit that ends its name in `Timing.figures`."""
        found: dict[str, Any] = {"worst": self.worst, **self.details}
        if self.where is not None:
            found["function"] = self.where
        return {**found, "limit": self.limit, "passed": self.passed}


@dataclass(frozen=True)
class Cost:
    """A function's calls: the longest one, with all it calls, and its own share of the cycles, %.

    Interrupts and sleep during a call are not counted.
    """

    function: str
    calls: int
    longest: int
    own_percent: float


@dataclass(frozen=True)
class Timing:
    """All figures of one binary.

    figures -- by name in the JSON, which ends in the unit; without a keypad, its figure is left
    out. functions -- those with the longest calls after the start of main. idle_fraction -- share
    of the time asleep. seconds -- simulated time that was measured.
    """

    figures: Mapping[str, Figure]
    functions: tuple[Cost, ...]
    idle_fraction: float
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether all figures are within their limits."""
        return all(figure.passed for figure in self.figures.values())

    def as_json(self) -> dict[str, Any]:
        """Return all figures as JSON data."""
        return {
            **{name: figure.as_json() for name, figure in self.figures.items()},
            "functions": [
                {
                    "function": cost.function,
                    "calls": cost.calls,
                    "longest_cycles": cost.longest,
                    "own_percent": cost.own_percent,
                }
                for cost in self.functions
            ],
            "idle_fraction": self.idle_fraction,
            "seconds": self.seconds,
            "passed": self.passed,
        }
