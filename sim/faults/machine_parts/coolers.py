"""Coolers that are always or never on, and fast alternation of heating and cooling.

While a fault is latched the cooler must be on if the reading is hot or invalid.
"""

from collections.abc import Iterator

from heatwright.sim.faults import effects, starts
from heatwright.sim.faults.bounds import watchdog_s
from heatwright.sim.faults.controller import processor
from heatwright.sim.faults.effects import Heated
from heatwright.sim.faults.fault import Fault, Trip, harmless, watched
from heatwright.sim.faults.site import OfState
from heatwright.sim.faults.world import Site, World
from heatwright.sim.reference.loop import FAULT_COOLING_ABOVE_C

WATCH_S = 60.0
TURNS = 40
MARGIN_K = 5.0
BEYOND_K = 30.0
LONGEST_S = 60.0


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the loop's cooler."""
    cooler = site.loop.cooler
    if cooler is None:
        return
    shorted = Heated(cooler, effects.SHORTED)
    yield watched(site, "cooler_shorted", shorted, shorted.mend)
    dead = Heated(cooler, effects.OPENED)
    yield Fault("cooler_dead", lambda: cooling(site), dead, calm=True, watch_s=WATCH_S)
    if site.is_set:
        yield harmless(site, "heating_and_cooling_by_turns", _turns, for_s=0.0)
    yield Fault(
        "hung_while_cooling",
        lambda: cooling(site),
        lambda world: processor.hang(world, processor.INTERRUPTS_ON),
        trip=Trip(("watchdog_reset",), watchdog_s(site)),
    )


def cooling(site: Site) -> World:
    """Return a world well above its setpoint, with the cooler on."""
    target_c = starts.setpoints_c(site)[0]
    start_c = min(target_c + BEYOND_K, site.loop.protection.maximum_c - MARGIN_K)
    world = starts.begun(site, start_c)
    world.set_setpoint(target_c)
    world.until(OfState(lambda now: now.loop("cooling") == 1), LONGEST_S)
    return world


def _turns(world: World) -> None:
    """Alternate between the highest and the lowest setpoint, as fast as control steps use them."""
    high_c, low_c = starts.highest_c(world.site), starts.setpoints_c(world.site)[0]
    for turn in range(TURNS):
        world.set_setpoint(low_c if turn % 2 == 0 else high_c)
        world.run(world.site.loop.periods_s(2))


COOLED_ABOVE_C = float(FAULT_COOLING_ABOVE_C)
"""Under a fault the cooler is off only if a valid reading is below (docs/control.md, "Cooler")."""


def complaint(world: World) -> str:
    """Return what is wrong with the cooler's state under a latched fault, or ""."""
    cooler = world.site.loop.cooler
    if cooler is None or world.until(_is_right, _held_s(world, cooler)):
        return ""
    runs = "on" if world.device.outputs[cooler].on else "off"
    return f"cooler {cooler} is wrongly {runs} at {world.loop('temperature_c'):.1f} °C"


def _held_s(world: World, cooler: str) -> float:
    """Return how long minimum times, and the wait for the next step, may delay the cooler, s."""
    output = world.site.controller.on_off_output(cooler)
    return world.site.loop.next_step_s(max(output.minimum_on_s, output.minimum_off_s))


def _is_right(world: World) -> bool:
    """Whether the cooler runs if it must, by the reading, which is checked elsewhere."""
    must = bool(world.loop("reading_status")) or world.loop("temperature_c") >= COOLED_ABOVE_C
    return bool(world.device.outputs[world.site.loop.cooler or ""].on == must)
