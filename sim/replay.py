"""Repeat the binary's control steps with the reference model, and compare them bit for bit.

The reference model gets the inputs of each step: reading, setpoint and acknowledgement; for a
commanded loop also switch, mode, manual duty, gains, emergency stop and the start of a tuning; for
a programmed one the commands and the copy of the program; the critical temperature; the heater's
current. Every other member must be equal to the last bit. Series of steps in which only readings
and commands are new are compared side by side, each from the state that the log has before it.

Some inputs are not members of the log. Acknowledgements and starts are derived from their counts; a
stop, a lost master and a bad relay from the fault's code. A fault that survived a reset, or caused
it, is taken from the first step after the reset and listed in `ReplayResult.restored`, as the log
cannot prove it. The same applies to a program that survived a reset.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from heatwright.sim.arrays.steps import bits
from heatwright.sim.judges.lockouts import TRIPS, miscounts
from heatwright.sim.player import LOADED, Latched, Player, Restored
from heatwright.sim.reference.numbers import Member
from heatwright.sim.trace import StepLog
from heatwright.spec import Controller
from heatwright.spec.board.timers import TICK_S

MOST_SHOWN = 10

NO_MEMBERS = ("time_s", LOADED)


class ReplayError(ValueError):
    """The log cannot be replayed."""


@dataclass(frozen=True)
class Mismatch:
    """One member of the state that differs after one step."""

    row: int
    time_s: float
    variable: str
    expected: str
    """The reference model's value, as a number and its bits."""
    actual: str

    def __str__(self) -> str:
        """Describe the mismatch in one line."""
        return (
            f"step {self.row} at {self.time_s:.3f} s: {self.variable} is {self.actual}, "
            f"not {self.expected}"
        )


@dataclass(frozen=True)
class ReplayResult:
    """The result of a comparison of the binary with the reference model."""

    ticks: int
    """Number of control steps compared."""
    mismatches: int
    """Number of members that differ, over all steps."""
    first: tuple[Mismatch, ...]
    """The first few mismatches."""
    segments: int
    """Number of series of steps between resets."""
    restored: tuple[Restored, ...]
    latched: tuple[Latched, ...]
    """Faults that were latched in a step, or between it and the step before."""
    unchecked: tuple[str, ...]
    """Members of the log that the reference model does not have."""


def replay_all(controller: Controller, logs: Mapping[str, StepLog]) -> dict[str, ReplayResult]:
    """Compare the logs of all loops with the reference model.

    A fault stops every loop. The reference model says which loop has tripped it: if none has, that
    is a mismatch. A fault that another loop has tripped is not listed as `restored`. Raises
    ReplayError: a log is empty or lacks a member.
    """
    results = {name: replay(controller, log, name) for name, log in logs.items()}
    own = [each for result in results.values() for each in result.latched if each.own]
    slowest_s = controller.longest_period_s + TICK_S

    def is_anothers(seen: Latched | Restored) -> bool:
        return any(
            each.fault_code == seen.fault_code and abs(each.time_s - seen.time_s) <= slowest_s
            for each in own
        )

    found = {}
    for name, result in results.items():
        restored = tuple(each for each in result.restored if not is_anothers(each))
        orphans = [each for each in result.latched if not each.own and not is_anothers(each)]
        found[name] = _with_orphans(replace(result, restored=restored), orphans)
    return found


def _with_orphans(result: ReplayResult, orphans: list[Latched]) -> ReplayResult:
    """Add a mismatch for each fault whose rule no loop has broken."""
    found = tuple(
        Mismatch(each.row, each.time_s, "fault.code", "0", str(each.fault_code)) for each in orphans
    )
    first = (*found, *result.first)[:MOST_SHOWN]
    return replace(result, mismatches=result.mismatches + len(found), first=first)


def replay(controller: Controller, log: StepLog, loop: str | None = None) -> ReplayResult:
    """Compare a log of control steps with the reference model.

    The step counter must increase by one each time: a missing or repeated step is a mismatch. An
    unexpected counter of 1 is a reset.

    controller -- the specification; log -- one row per control step; loop -- name of the loop; the
    first if None. Raises ReplayError: the log is empty or lacks a member.
    """
    name = loop or next(iter(controller.loops))
    if not len(log):
        raise ReplayError("There are no control steps to compare")
    player = Player(controller, name)
    _check_members(log, player.members)
    expected = player.play(log)
    found = [
        (int(row), member)
        for member, _ in player.members
        for row in np.flatnonzero(bits(expected[member]) != bits(log[member]))
    ]
    found.sort(key=lambda item: item[0])
    counted = [
        Mismatch(each.row, float(log["time_s"][each.row]), TRIPS, each.expected, each.actual)
        for each in miscounts(controller, log, name)
    ]
    held = {*NO_MEMBERS, TRIPS, *dict(player.members)}
    first = (*counted, *(_mismatch(log, expected, *item) for item in found[:MOST_SHOWN]))
    return ReplayResult(
        ticks=len(log),
        mismatches=len(found) + len(counted),
        first=first[:MOST_SHOWN],
        segments=player.segments,
        restored=tuple(player.restored),
        latched=tuple(player.latched),
        unchecked=tuple(sorted({*(log.dtype.names or ())} - held)),
    )


def _check_members(log: StepLog, members: list[Member]) -> None:
    found = log.dtype.names or ()
    wanted = [name for name, _ in members]
    if any(name.startswith("program.") for name in wanted):
        wanted.append(LOADED)
    lacking = [name for name in wanted if name not in found]
    if lacking:
        raise ReplayError(f"The log lacks {', '.join(lacking)}")
    for name, width in members:
        if log.dtype[name] != np.dtype(width):
            raise ReplayError(f"{name} is {log.dtype[name]} in the log, not {np.dtype(width)}")


def _mismatch(log: StepLog, expected: StepLog, row: int, member: str) -> Mismatch:
    return Mismatch(
        row=row,
        time_s=float(log["time_s"][row]),
        variable=member,
        expected=_shown(expected[member][row]),
        actual=_shown(log[member][row]),
    )


def _shown(value: np.generic) -> str:
    if isinstance(value, np.floating):
        return f"{value!s} (0x{value.view(np.uint32):08x})"
    return str(value)
