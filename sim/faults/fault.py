"""What a fault is, and what is found when it is tried."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from heatwright.sim.faults.world import Condition, World

Act = Callable[[World], None]
Judge = Callable[[World], str]


def nothing(world: World) -> None:
    """Do nothing."""
    del world


def at_once(world: World) -> bool:
    """Return True: the cause itself is what the rule judges."""
    del world
    return True


def no_complaint(world: World) -> str:
    """Return "": there is nothing more to look at."""
    del world
    return ""


@dataclass(frozen=True)
class Trip:
    """A rule has to trip.

    rules -- ids of the rules of which one must; allowed_s -- bound on the time it takes since the
    rule's condition has been met without a gap; due -- whether it is met; due_within_s -- how long
    the machine may take until then.
    """

    rules: tuple[str, ...]
    allowed_s: float
    due: Condition = at_once
    due_within_s: float = 0.0


@dataclass(frozen=True)
class Fault:
    """One way to fail, and what has to follow.

    make -- gives a world in the state the fault meets; cause, cure -- bring it and take it away.
    trip -- what has to trip; None: nothing may. off_within_s -- bound on the time from the cause to
    heater off, where the heater must be off before the rule trips. again -- what has to trip after
    an acknowledgement while the cause goes on; None: no rule can tell. watch_s -- for how long
    nothing may trip; may -- rules that may be latched then all the same. judge -- looks at the
    world at the end and says what is wrong, or "".
    """

    id: str
    make: Callable[[], World]
    cause: Act
    cure: Act = nothing
    trip: Trip | None = None
    off_within_s: float | None = None
    again: Trip | None = None
    watch_s: float = 0.0
    may: tuple[str, ...] = ()
    judge: Judge = no_complaint


@dataclass(frozen=True)
class FaultResult:
    """What was found.

    fault -- its id; rule -- id of the rule that tripped, None if none did; expected -- ids of the
    rules of which one must trip (none: nothing may trip); tripped_after_s -- since the condition of
    the rule was met, s; allowed_s -- the bound on that, from the specification; heater_off_after_s
    -- since the same moment or, where it is bounded by itself, since the cause; peak_c -- highest
    temperature at the loop's sensor, from the cause until shortly after the trip.
    """

    fault: str
    rule: str | None
    expected: tuple[str, ...]
    tripped_after_s: float | None
    allowed_s: float | None
    heater_off_after_s: float | None
    peak_c: float
    problems: tuple[str, ...] = field(default=())

    @property
    def passed(self) -> bool:
        """Whether everything was as it has to be."""
        return not self.problems

    @property
    def detail(self) -> str:
        """What is wrong, or ""."""
        return "; ".join(self.problems)

    def as_json(self) -> dict[str, Any]:
        """Return it for machines; times in s, temperatures in °C."""
        return {
            "fault": self.fault,
            "rule": self.rule,
            "expected": list(self.expected),
            "tripped_after_s": _rounded(self.tripped_after_s),
            "allowed_s": _rounded(self.allowed_s),
            "heater_off_after_s": _rounded(self.heater_off_after_s),
            "peak": _rounded(self.peak_c),
            "passed": self.passed,
            "detail": self.detail,
        }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 3)
