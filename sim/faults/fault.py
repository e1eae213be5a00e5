"""One fault that `verify` tries, its usual forms, and the result of its trial."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from heatwright.sim.faults import starts
from heatwright.sim.faults.machine import watch_s
from heatwright.sim.faults.world import Condition, Site, World

Act = Callable[[World], None]
Judge = Callable[[World], str]


def nothing(world: World) -> None:
    """Do nothing."""
    del world


def at_once(world: World) -> bool:
    """Return True: the condition of the rule is met as soon as the cause is there."""
    del world
    return True


def no_complaint(world: World) -> str:
    """Return "", for a fault without a check of its own."""
    del world
    return ""


@dataclass(frozen=True)
class Trip:
    """A trip that must come, independently of the temperatures of the machine.

    rules -- ids of the rules of which one must trip; empty: the one that trips first in the model;
    allowed_s -- longest time from when `due` is true, without a gap, to the trip; due_within_s --
    longest time until `due` is true; certain -- whether `due` becomes true on every machine.
    """

    rules: tuple[str, ...]
    allowed_s: float
    due: Condition = at_once
    due_within_s: float = 0.0
    certain: bool = True


@dataclass(frozen=True)
class Fault:
    """One way to fail: its cause, its cure, and how long the machine is watched.

    The expected trip is not given here: the reference model gets the same readings and determines
    which rule trips first, and when. The plant has the limits of the machine's temperatures.

    make -- creates a world in the state in which the fault occurs; cause, cure -- begin and end the
    fault; watch_s -- how long to watch if nothing trips; calm -- only the rules of `may` may trip,
    also before the cause; trip -- the trip that must come and its bound, if these do not depend on
    the machine: there are no more readings, or the processor is reset; off_within_s -- bound on the
    time from the cause to heater off, if the heater must be off before the trip; all_off -- this
    bound is for the heaters of all loops; sensor_lies -- the reading of the loop's sensor may
    differ from its tip; others_lie -- other loops, and monitors as monitor_NAME, whose readings may
    differ; current_lies -- a measured current may differ from the real one; again -- the fault is
    acknowledged while the cause lasts; insisted -- it is acknowledged at each trip, and heat is
    commanded, until the lock-out, each time as soon as the tip moves too slowly for `rise_rate`:
    that gives most heat; floats -- heaters' pins may be left undriven: resistors keep them off;
    judge -- checks the world at the end: returns what is wrong, or "".
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
    """The result of one trial.

    fault -- its id; loop -- the loop under test; calm -- no rule was to trip; rule -- id of the
    rule that tripped, or None; counting -- ids of the rules that were counting steps at the trip,
    or at the end without one: they would have tripped next; tripped_after_s -- time from cause to
    trip, s; allowed_s -- bound on that time, if there is one that does not depend on the machine;
    heater_off_after_s -- time from the cause until the heater was last on, s; peak_c -- highest
    temperature at the loop's sensor, from the cause until the heat has spread after the trip.
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
        """Whether the trial found no problem."""
        return not self.problems

    @property
    def detail(self) -> str:
        """All problems in one line, or ""."""
        return "; ".join(self.problems)

    def as_json(self) -> dict[str, Any]:
        """Return the result as JSON data; times in s, temperatures in °C."""
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


def harmless(site: Site, name: str, cause: Act, for_s: float, judge: Judge = no_complaint) -> Fault:
    """Return a fault at which no rule may trip; it is watched for a time, s."""
    return Fault(name, lambda: starts.heating(site), cause, calm=True, watch_s=for_s, judge=judge)


def tripping(site: Site, name: str, cause: Act, trip: Trip, cure: Act = nothing) -> Fault:
    """Return a fault at which a rule must trip."""
    return Fault(name, lambda: starts.heating(site), cause, cure, trip=trip)


def watched(site: Site, name: str, cause: Act, cure: Act) -> Fault:
    """Return a fault that is watched until a rule trips, and again after an acknowledgement."""
    return Fault(name, lambda: starts.heating(site), cause, cure, watch_s=watch_s(site), again=True)
