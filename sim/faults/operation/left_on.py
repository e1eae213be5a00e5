"""A loop that nobody switches off: `on_for_at_most` ends, and starts anew only when it is off."""

from collections.abc import Iterator
from dataclasses import replace

from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import TICK_S, reading_s
from heatwright.sim.faults.controller import memory
from heatwright.sim.faults.fault import Fault, Trip, harmless, nothing, tripping
from heatwright.sim.faults.world import Site, World
from heatwright.spec import Controller

TOO_LONG = "on_too_long"
SHARE = 0.6
"""Share of `on_for_at_most` for which the loop is on before it is switched off, and again after:
both together are longer than `on_for_at_most`."""


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults that test `on_for_at_most`, if the loop has it."""
    most_s = site.loop.protection.on_for_at_most_s
    if most_s is None:
        return

    def switch_anew(world: World) -> None:
        world.run(SHARE * most_s)
        world.switch_off()
        starts.first_steps(world)
        world.set_setpoint(starts.highest_c(site))

    ends = Trip((TOO_LONG,), site.loop.next_step_s(most_s) + TICK_S)
    yield tripping(site, "left_on", nothing, ends)
    yield harmless(site, "switched_on_anew", switch_anew, SHARE * most_s)
    flipped = Trip(("memory_damaged",), reading_s(site.loop))
    yield tripping(site, "on_time_flipped", _flip, flipped)


def over_meanwhile(controller: Controller, found: list[Fault]) -> list[Fault]:
    """Allow `on_too_long` in trials without a trip, which may be longer than `on_for_at_most`."""
    if not any(each.protection.on_for_at_most_s for each in controller.loops.values()):
        return found
    return [
        replace(each, may=(*each.may, TOO_LONG)) if each.calm and each.watch_s else each
        for each in found
    ]


def _flip(world: World) -> None:
    """Flip a bit of the count of steps for which the loop has been on."""
    memory.flip(world, f"guard_{world.site.loop_name}.on_steps", memory.LOWEST_BIT)
