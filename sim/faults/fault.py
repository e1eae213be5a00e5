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
    """A fault has to be latched, whatever the machine does meanwhile.

    rules -- ids of those of which one must; none: whichever the reference model names first;
    allowed_s -- bound on the time it takes since `due` has been met without a gap; due_within_s --
    how long the machine may take until then; certain -- whether every machine gets there.
    """

    rules: tuple[str, ...]
    allowed_s: float
    due: Condition = at_once
    due_within_s: float = 0.0
    certain: bool = True


@dataclass(frozen=True)
class Fault:
    """One way to fail: what happens, what ends it, and for how long it is watched.

    What follows is not written here: the reference model takes the same readings and says which
    rule is met first, and when. The machine says what it bears.

    make -- gives a world in the state the fault meets; cause, cure -- bring it and take it away.
    watch_s -- for how long it is watched where nothing trips. calm -- the machine is well all the
    same: nothing may trip but `may`, which may be latched before, too. trip -- a fault has to be
    latched so soon, where that does not depend on the machine: no reading comes any more, the
    processor is reset. off_within_s -- bound on the time from the cause to heater off, where the
    loop's heater must be off before; all_off -- and so must those of all other loops. sensor_lies
    -- whether the loop's sensor itself says what its tip does not feel; others_lie -- the other
    loops whose sensors do so, and monitors, as monitor_NAME; current_lies -- whether a sensor of a
    current says what does not flow. again -- whether it is acknowledged while the cause goes on;
    insisted -- whether that is done at every trip, and heat asked for, until a person has to come.
    floats -- whether the pins of heaters may be let go, off by the resistors at their switches.
    judge -- looks at the world at the end and says what is wrong, or "".
    """

    id: str
    make: Callable[[], World]
    cause: Act
    cure: Act = nothing
    watch_s: float = 0.0
    calm: bool = False
    trip: Trip | None = None
    off_within_s: float | None = None
    all_off: bool = False
    sensor_lies: bool = False
    others_lie: tuple[str, ...] = ()
    current_lies: bool = False
    again: bool = False
    insisted: bool = False
    floats: bool = False
    may: tuple[str, ...] = ()
    judge: Judge = no_complaint


@dataclass(frozen=True)
class FaultResult:
    """What was found.

    fault -- its id; loop -- on which it was tried; calm -- whether nothing was to trip; rule -- id
    of the rule that tripped, None if none did; counting -- ids of the rules that counted then, too,
    or that counted when the watch ended: those that would have come next; tripped_after_s -- since
    the cause, s; allowed_s -- the bound on that, where there is one that does not depend on the
    machine; heater_off_after_s -- when the heater was last on, since the cause, s; peak_c --
    highest temperature at the loop's sensor, from the cause until the heat has spread after the
    trip.
    """

    fault: str
    loop: str
    calm: bool
    rule: str | None
    counting: tuple[str, ...]
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
            "loop": self.loop,
            "calm": self.calm,
            "rule": self.rule,
            "counting": list(self.counting),
            "tripped_after_s": _rounded(self.tripped_after_s),
            "allowed_s": _rounded(self.allowed_s),
            "heater_off_after_s": _rounded(self.heater_off_after_s),
            "peak": _rounded(self.peak_c),
            "passed": self.passed,
            "detail": self.detail,
        }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 3)
