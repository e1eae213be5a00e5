"""What was measured, each figure with its limit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

BUTTON_MS = 50.0
"""A key is answered at once: a tenth of a second is what a person notices, and this is half."""
JITTER_US = 1000.0
"""A thousandth of the usual control period of 1 s; for each loop, as one's step may come after
those of all others."""
BUSY_US = 100.0
"""Nothing may wait longer for anything than two instructions of the display take."""
SLOT_US = 70.0
"""Interrupts off in a slot of the 1-Wire bus, which lasts 60 µs at least."""


@dataclass(frozen=True)
class Figure:
    """The worst measured value of a quantity, its limit, and details.

    what -- the quantity, in words; unit -- ms, µs or bytes; worst -- None if it could not be
    measured, which fails; where -- the function in which it was found; details -- further numbers,
    by name.
    """

    what: str
    unit: str
    worst: float | None
    limit: float
    where: str | None = None
    details: Mapping[str, float] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """Whether it is within its limit."""
        return self.worst is not None and self.worst <= self.limit

    def as_json(self) -> dict[str, Any]:
        """Return it for machines, in the unit its name there ends in."""
        found: dict[str, Any] = {"worst": self.worst, **self.details}
        if self.where is not None:
            found["function"] = self.where
        return {**found, "limit": self.limit, "passed": self.passed}


@dataclass(frozen=True)
class Cost:
    """A function's calls and cycles: the longest call, with all it calls, and its own, %.

    Interrupts that came meanwhile are not counted.
    """

    function: str
    calls: int
    longest: int
    own_percent: float


@dataclass(frozen=True)
class Timing:
    """Every figure of one binary.

    figures -- by its name in the JSON, which ends in its unit; a controller without a keypad has
    none for it. functions -- those with the longest calls, once main has begun.
    idle_fraction -- of the time, asleep. seconds -- of simulated time that were measured.
    """

    figures: Mapping[str, Figure]
    functions: tuple[Cost, ...]
    idle_fraction: float
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether all of it is within its limits."""
        return all(figure.passed for figure in self.figures.values())

    def as_json(self) -> dict[str, Any]:
        """Return it for machines."""
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
