"""When the condition of a rule is met, told from the machine rather than from the firmware.

Each looks at the sensor's tip, with what the sensor's steps may make of it.
"""

from __future__ import annotations

from heatwright.sim.faults.machine import blur_k, late_k
from heatwright.sim.faults.world import Condition, World


def reaches(limit_c: float) -> Condition:
    """At a limit, coming from below."""
    return lambda world: world.tip_c >= limit_c + late_k(world.site, limit_c)


def exceeds(limit_c: float) -> Condition:
    """Above a limit, also by its nearest step."""
    return lambda world: world.tip_c > limit_c + abs(late_k(world.site, limit_c))


def falls_to(limit_c: float) -> Condition:
    """At a limit, coming from above."""
    return lambda world: world.tip_c <= limit_c - late_k(world.site, limit_c)


def falls_below(limit_c: float) -> Condition:
    """Below a limit, also by its nearest step."""
    return lambda world: world.tip_c < limit_c - abs(late_k(world.site, limit_c))


def at_full_power(full_percent: float) -> Condition:
    """Whether the loop asks for all its heater may give."""
    return lambda world: world.loop("duty_percent") >= full_percent


class Risen:
    """Whether the tip is so far above its lowest temperature since a time after the first look."""

    def __init__(self, rise_k: float, settle_s: float = 0.0) -> None:
        self._rise_k = rise_k
        self._settle_s = settle_s
        self._began_s: float | None = None
        self._lowest_c = float("inf")

    def __call__(self, world: World) -> bool:
        """Look."""
        if self._began_s is None:
            self._began_s = world.now_s
        if world.now_s < self._began_s + self._settle_s:
            return False
        self._lowest_c = min(self._lowest_c, world.tip_c)
        risen_c = self._lowest_c + self._rise_k
        return reaches(risen_c + blur_k(world.site, self._lowest_c))(world)
