"""How parts fail physically: a heater's power, and the temperature of a sensor's tip."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from heatwright.sim.faults.world import World
from heatwright.sim.machine import Feel, Heat

# -- heaters: from the power that the pin commands to the real power, in shares of full power ---

SHORTED = Heat(least=1.0)
"""The switch always conducts, whatever the pin says, as a broken-down transistor does."""
OPENED = Heat(times=0.0)
"""The heater never gets current: a broken wire, a blown fuse."""


def weakened(share: float) -> Heat:
    """Give only a share of the commanded power: a strand is broken, or the supply is low."""
    return Heat(times=share)


def leaking(share: float) -> Heat:
    """Give at least this share of full power, even while the pin is off."""
    return Heat(least=share)


@dataclass(frozen=True)
class Heated:
    """A change of a load's power. Equal changes compare equal: they are one cause of a fault."""

    load: str
    heat: Heat

    def __call__(self, world: World) -> None:
        """Begin the change."""
        world.wiring.heat[self.load] = self.heat

    def mend(self, world: World) -> None:
        """End the change."""
        world.wiring.heat.pop(self.load)


# -- sensors: from the machine's temperature to the tip's, °C ----------------------------------

Change = Callable[[World], Feel]


@dataclass(frozen=True, eq=False)
class Felt:
    """A change of a sensor's tip; change -- called when the fault begins, returns the change."""

    sensor: str
    change: Change

    def __call__(self, world: World) -> None:
        """Begin the change."""
        world.wiring.feel[self.sensor] = self.change(world)

    def mend(self, world: World) -> None:
        """Let the tip feel the machine's temperature again."""
        world.wiring.feel.pop(self.sensor)


def standing(tip_c: float) -> Change:
    """Let the tip be at a constant temperature, °C."""
    return lambda _world: lambda _felt_c: tip_c


def fallen_out(world: World, lag_s: float) -> Feel:
    """Let the tip go to the ambient temperature from now on, with the sensor's lag."""
    began_s, from_c = world.now_s, world.sensed_c

    def feel(_: float) -> float:
        left = math.exp(-(world.now_s - began_s) / lag_s) if lag_s else 0.0
        return world.ambient_c + (from_c - world.ambient_c) * left

    return feel


def drifting(world: World, rate_k_per_s: float, end_c: float) -> Feel:
    """Let the tip go from its present temperature to another one at a constant rate."""
    began_s, from_c = world.now_s, world.sensed_c
    reach_s = abs(end_c - from_c) / abs(rate_k_per_s)

    def feel(_: float) -> float:
        return from_c + rate_k_per_s * min(world.now_s - began_s, reach_s)

    return feel


def jumping(world: World, by_k: float, every_s: float) -> Feel:
    """Let the tip's temperature be wrong and right in turn, as a loose contact does."""
    began_s = world.now_s

    def feel(felt_c: float) -> float:
        turn = int((world.now_s - began_s) / every_s)
        return felt_c + by_k if turn % 2 == 0 else felt_c

    return feel
