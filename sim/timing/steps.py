"""The jitter of the control steps, and the duration of a tick's work."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.binary.elf import Elf
from heatwright.sim.binary.profile import Profile
from heatwright.sim.timing.figures import JITTER_US, Figure

Cycles = NDArray[np.uint64]

STEP = "guard_{loop}_step"
"""Called once in every control step of a loop, with or without a fault."""
TICK = "gate_tick"
"""Called once in every tick, by the timer's interrupt."""
WAIT = "clock_wait"
"""Called once for every tick, when its work is done."""


def handlers(program: Elf) -> list[str]:
    """Return the names of the interrupts' functions."""
    return [each.name for each in program.functions if each.name.startswith("__vector_")]


def trace(profile: Profile, program: Elf, loops: list[str]) -> None:
    """Log the calls from which `jitter` and `longest_tick` are computed, from now on."""
    for name in [TICK, WAIT, *handlers(program), *(STEP.format(loop=loop) for loop in loops)]:
        profile.trace(name)


def jitter(
    entries: Cycles, period_s: float, clock_hz: int, loop: str, limit_us: float = JITTER_US
) -> Figure:
    """Compare the times of the steps with a regular grid that begins at the first one, µs.

    Details: the drift is the slope of a line through the deviations, the spread the difference
    between the latest and the earliest.
    """
    what = f"{loop}: jitter of the control step"
    if len(entries) < 2:
        return Figure(what, "µs", None, limit_us, details={"steps": len(entries)})
    late_us = deviations_us(entries, period_s, clock_hz)
    hours = np.arange(len(late_us)) * period_s / 3600
    drift = float(np.polyfit(hours, late_us, 1)[0])
    return Figure(
        what,
        "µs",
        float(np.abs(late_us).max()),
        limit_us,
        details={"spread": float(np.ptp(late_us)), "drift_per_hour": drift, "steps": len(entries)},
    )


def deviations_us(entries: Cycles, period_s: float, clock_hz: int) -> NDArray[np.float64]:
    """Return how late each call was on the grid of the first one, µs."""
    since = (entries - entries[0]).astype(np.float64)
    grid = np.arange(len(entries)) * (period_s * clock_hz)
    late: NDArray[np.float64] = (since - grid) * (1e6 / clock_hz)
    return late


def longest_tick(ticks: Cycles, waits: Cycles, wakes: Cycles, clock_hz: int) -> Figure:
    """Return the time from the timer's interrupt until the work of its tick is done, µs.

    The n-th tick's work is done at the n-th wait after the first one, even if a tick came during
    the work of the one before. The limit is the length of a tick.

    ticks -- when TICK was called; waits -- when WAIT was; wakes -- when any interrupt began, in
    order.
    """
    count = min(len(ticks), len(waits) - 1)
    what = "work of a tick"
    if count < 1:
        return Figure(what, "µs", None, 0.0)
    began = wakes[np.searchsorted(wakes, ticks[:count], side="right") - 1]
    took: NDArray[Any] = waits[1 : count + 1].astype(np.int64) - began.astype(np.int64)
    every = float(np.median(np.diff(ticks))) if len(ticks) > 1 else 0.0
    us = 1e6 / clock_hz
    return Figure(
        what,
        "µs",
        float(took.max()) * us,
        every * us,
        details={"mean": float(took.mean()) * us, "ticks": count},
    )
