"""Faults of the machine's inputs: a contact opens, bounces, or opens and closes again."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import TICK_S
from heatwright.sim.faults.fault import Fault, Trip, harmless, tripping
from heatwright.sim.faults.machine import watch_s
from heatwright.sim.faults.world import Site, World
from heatwright.spec import Input

BOUNCES = 30
AGAIN_S = 3600.0
"""Within this time a loop that cooled during a pause has its heater on again."""
LONGEST_S = 1800.0
"""Longer than a door usually stands open, and than the usual times of the rules."""


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of each input."""
    for name, each in site.controller.safety.inputs.items():
        yield _opens(site, name, each) if each.trips else _pauses(site, name)
        if each.for_s > 2 * TICK_S:
            yield _bounces(site, name, each)


def _opens(site: Site, name: str, each: Input) -> Fault:
    """Return a contact that opens: a pressed emergency stop, a cut-out, or a torn wire."""
    trip = Trip(("input_open",), site.loop.next_step_s(each.for_s) + 2 * TICK_S)
    opens, closes = (partial(_move, name=name, is_open=is_open) for is_open in (True, False))
    found = tripping(site, f"input_{name}_opens", opens, trip, closes)
    return replace(found, off_within_s=2 * TICK_S, all_off=True, again=True)


def _pauses(site: Site, name: str) -> Fault:
    """Return a door that is open for long: no heat and no trip until it is closed, then heat."""
    on_s = site.loop.protection.on_for_at_most_s or math.inf
    opened_s = math.nan

    def cause(world: World) -> None:
        nonlocal opened_s
        opened_s = world.now_s
        _move(world, name, is_open=True)

    def judge(world: World) -> str:
        world.device.feed()
        last_s = world.heaters.last_on_s(opened_s + 2 * TICK_S)
        if last_s is not None:
            return f"a heater was on {last_s - opened_s:.3f} s after the input opened"
        _move(world, name, is_open=False)
        again = world.until(starts.heater_on(site), AGAIN_S)
        return "" if again else "the heater stays off though the input is closed again"

    for_s = min(LONGEST_S, watch_s(site), on_s / 2)
    return harmless(site, f"input_{name}_opens", cause, for_s, judge)


def _bounces(site: Site, name: str, each: Input) -> Fault:
    """Return a contact that bounces: it opens repeatedly, but for less than the input's `for`."""
    open_s = each.for_s - 2 * TICK_S

    def shake(world: World) -> Callable[[float], None]:
        contact, begins_s = world.device.contacts[name], world.now_s

        def act(ends_s: float) -> None:
            contact.move(is_open=True)
            world.device.advance(min(begins_s + open_s, ends_s))
            contact.move(is_open=False)
            world.device.advance(ends_s)

        return act

    def cause(world: World) -> None:
        for _ in range(BOUNCES):
            world.act_within(shake(world))
            world.run(site.loop.periods_s(1))

    def judge(world: World) -> str:
        return "" if world.until(starts.heater_on(site), AGAIN_S) else "heater is off"

    return harmless(site, f"input_{name}_bounces", cause, site.loop.periods_s(1), judge)


def _move(world: World, name: str, *, is_open: bool) -> None:
    world.device.contacts[name].move(is_open=is_open)
