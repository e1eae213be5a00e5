"""Faults of a thermocouple converter on its wires: wires, supply, thermocouple, conversions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import cast

from heatwright.sim.faults import starts
from heatwright.sim.faults.fault import Act, Fault
from heatwright.sim.faults.machine import watch_s
from heatwright.sim.faults.sensing.readings import DAMAGED_ANSWERS, bursts, no_reading
from heatwright.sim.faults.world import Site, World
from heatwright.sim.native.pins import Level
from heatwright.sim.reference.numbers import steps
from heatwright.sim.sensors.spi_chip import Faults, SpiChip

WATCH_S = 120.0
SOUND_PER_DAMAGED = 4
"""In bursts so many answers are sound for each that is not."""


def cut(world: World) -> None:
    """Break the thermocouple."""
    chip_of(world).faults.open = True


def mend(world: World) -> None:
    """Weld it again."""
    chip_of(world).faults.open = False


def faults(site: Site) -> Iterator[Fault]:
    """Yield what applies to those that only answer."""
    yield from wires(site)
    yield no_reading(site, "thermocouple_broken", cut, mend)
    yield failing_supply(site)
    yield from conversions(site)


def on_chip(act: Callable[[SpiChip], None]) -> Act:
    """Do something to the chip of the loop's sensor."""
    return lambda world: act(chip_of(world))


def chip_of(world: World) -> SpiChip:
    """Return the chip of the loop's sensor."""
    return cast("SpiChip", world.device.sensors[world.site.loop.sensor])


def _fail(faults: Faults) -> Act:
    """Give the chip these faults and no others."""
    return on_chip(lambda chip: setattr(chip, "faults", replace(faults)))


def wires(site: Site) -> Iterator[Fault]:
    """Yield what makes the chip no longer answer, or badly."""
    sound = _fail(Faults())
    yield no_reading(site, "unplugged", on_chip(SpiChip.unplug), on_chip(SpiChip.plug))
    yield no_reading(site, "data_shorted_to_ground", _short("low"), _short(None))
    yield no_reading(site, "data_shorted_to_supply", _short("high"), _short(None))
    yield no_reading(site, "no_clock", _fail(Faults(dumb=True)), sound)
    yield no_reading(site, "damaged_answers", _fail(Faults(corrupt_rate=1.0)), sound)


def failing_supply(site: Site) -> Fault:
    """Return what breaks the chip's supply down again and again."""
    return no_reading(site, "failing_supply", _failing_supply, _leave_alone)


def conversions(site: Site, anew_s: float = 0.0) -> Iterator[Fault]:
    """Yield what conversions can suffer, and what must not stop a machine.

    anew_s -- what a damaged answer costs a chip that is set up anew then, until its next one, s.
    """
    yield from _frozen(site)
    yield from _harmless(site, anew_s)


def _short(level: Level | None) -> Act:
    return on_chip(lambda chip: chip.short(level))


def _failing_supply(world: World) -> None:
    """Break the chip's supply down in every step of time, sooner than a conversion ends."""

    def feel(felt_c: float) -> float:
        chip_of(world).brown_out()
        return felt_c

    world.wiring.feel[world.site.loop.sensor] = feel


def _bursts(world: World, anew_s: float) -> None:
    """Damage one answer fewer in a row than the controller is patient with, over and over.

    A chip that is set up anew after each of them has its next answer only when it has converted.
    """
    loop = world.site.loop
    taken = max(1, math.ceil(loop.periods_in(anew_s)))
    most = max(1, (steps(loop.protection.stale_after_s, loop) - 1) // taken)
    every_s = loop.periods_s((1 + SOUND_PER_DAMAGED) * most)
    turn = int(world.now_s / every_s)

    def feel(felt_c: float) -> float:
        nonlocal turn
        now = int(world.now_s / every_s)
        if now != turn:
            chip_of(world).faults.corrupt_next = most
        turn = now
        return felt_c

    world.wiring.feel[loop.sensor] = feel


def _bursts_end(world: World) -> None:
    _leave_alone(world)
    chip_of(world).faults.corrupt_next = 0


def _leave_alone(world: World) -> None:
    world.wiring.feel.pop(world.site.loop.sensor)


def _frozen(site: Site) -> Iterator[Fault]:
    """Conversions that return the reading of this moment for ever, while the machine heats."""
    yield Fault(
        "frozen",
        lambda: starts.heating(site),
        _fail(Faults(frozen=True)),
        _fail(Faults()),
        watch_s=watch_s(site),
        sensor_lies=True,
        again=True,
    )


def _harmless(site: Site, anew_s: float) -> Iterator[Fault]:
    """What happens beside a heater's wires, and must not stop a sensor."""
    yield bursts(site, DAMAGED_ANSWERS, partial(_bursts, anew_s=anew_s), _bursts_end, WATCH_S)
    yield Fault(
        "supply_interrupted_once",
        lambda: starts.heating(site),
        on_chip(SpiChip.brown_out),
        calm=True,
        watch_s=WATCH_S,
        judge=_zeros_not_believed,
    )


def _zeros_not_believed(world: World) -> str:
    """Check that what the chip answers before its first conversion was no temperature."""
    log = world.device.steps(world.site.loop_name)
    lowest_c = float(log["temperature_c"][log["has_reading"] == 1].min())
    return f"{lowest_c:.1f} °C was taken for a temperature" if lowest_c == 0.0 else ""
