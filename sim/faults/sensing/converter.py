"""Faults of a thermocouple converter: its wires, supply, thermocouple and conversions."""

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
"""In bursts, this many answers are sound for each damaged one."""


def cut(world: World) -> None:
    """Break the thermocouple."""
    chip_of(world).faults.open = True


def mend(world: World) -> None:
    """Repair the thermocouple."""
    chip_of(world).faults.open = False


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of converters that can only be read, not configured."""
    yield from wires(site)
    yield no_reading(site, "thermocouple_broken", cut, mend)
    yield failing_supply(site)
    yield from conversions(site)


def on_chip(act: Callable[[SpiChip], None]) -> Act:
    """Return an act on the chip of the loop's sensor."""
    return lambda world: act(chip_of(world))


def chip_of(world: World) -> SpiChip:
    """Return the chip of the loop's sensor."""
    return cast("SpiChip", world.device.sensors[world.site.loop.sensor])


def _fail(faults: Faults) -> Act:
    """Return an act that gives the chip these faults and no others."""
    return on_chip(lambda chip: setattr(chip, "faults", replace(faults)))


def wires(site: Site) -> Iterator[Fault]:
    """Yield faults after which the chip does not answer, or answers badly."""
    sound = _fail(Faults())
    yield no_reading(site, "unplugged", on_chip(SpiChip.unplug), on_chip(SpiChip.plug))
    yield no_reading(site, "data_shorted_to_ground", _short("low"), _short(None))
    yield no_reading(site, "data_shorted_to_supply", _short("high"), _short(None))
    yield no_reading(site, "no_clock", _fail(Faults(dumb=True)), sound)
    yield no_reading(site, "damaged_answers", _fail(Faults(corrupt_rate=1.0)), sound)


def failing_supply(site: Site) -> Fault:
    """Return a fault in which the chip's supply fails again and again."""
    return no_reading(site, "failing_supply", _failing_supply, _leave_alone)


def conversions(site: Site, anew_s: float = 0.0) -> Iterator[Fault]:
    """Yield the faults of conversions, and disturbances that must not trip a rule.

    anew_s -- time until the next answer if the chip is set up again after a damaged answer, s.
    """
    yield from _frozen(site)
    yield from _harmless(site, anew_s)


def _short(level: Level | None) -> Act:
    return on_chip(lambda chip: chip.short(level))


def _failing_supply(world: World) -> None:
    """Interrupt the chip's supply in every step of time, so that no conversion ends."""

    def feel(felt_c: float) -> float:
        chip_of(world).brown_out()
        return felt_c

    world.wiring.feel[world.site.loop.sensor] = feel


def _bursts(world: World, anew_s: float) -> None:
    """Damage as many answers in a row as the controller just tolerates, again and again.

    A chip that is set up again after each of them answers only after its next conversion.
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
    """Yield a chip that repeats its present reading permanently, while the machine heats."""
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
    """Yield disturbances, such as a heater's wires cause: they must trip no rule of the sensor."""
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
    """Check that the chip's answer before its first conversion was not used as a temperature."""
    log = world.device.steps(world.site.loop_name)
    lowest_c = float(log["temperature_c"][log["has_reading"] == 1].min())
    return f"{lowest_c:.1f} °C was used as a temperature" if lowest_c == 0.0 else ""
