"""Faults of a thermocouple converter: its wires, supply, thermocouple and conversions."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, cast

from heatwright.sim.faults.effects import Felt
from heatwright.sim.faults.fault import Act, Fault, harmless, watched
from heatwright.sim.faults.sensing.readings import bursts_of_damage, no_reading, slow_conversions
from heatwright.sim.faults.world import Site, World
from heatwright.sim.machine import Feel
from heatwright.sim.native.pins import Level
from heatwright.sim.reference.numbers import steps
from heatwright.sim.sensors.spi_chip import Faults, SpiChip

KINDS = ("max6675",)
"""The kind of sensor that has these faults and no others (spec/registry.py)."""
WATCH_S = 120.0
SOUND_PER_DAMAGED = 4
"""In bursts, this many answers are sound for each damaged one."""
SLOW = 1.5


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


def on_chip(act: Callable[[Any], None]) -> Act:
    """Return an act on the chip of the loop's sensor."""
    return lambda world: act(chip_of(world))


def chip_of(world: World) -> SpiChip:
    """Return the chip of the loop's sensor."""
    return cast("SpiChip", world.device.sensors[world.site.loop.sensor])


def fail(faults: Any) -> Act:
    """Return an act that gives the chip these faults, of its own class, and no others."""
    return on_chip(lambda chip: setattr(chip, "faults", replace(faults)))


def wires(site: Site) -> Iterator[Fault]:
    """Yield faults after which the chip does not answer, or answers badly."""
    sound = fail(Faults())
    yield no_reading(site, "unplugged", on_chip(SpiChip.unplug), on_chip(SpiChip.plug))
    yield no_reading(site, "data_shorted_to_ground", short("low"), short(None))
    yield no_reading(site, "data_shorted_to_supply", short("high"), short(None))
    yield no_reading(site, "no_clock", fail(Faults(dumb=True)), sound)
    yield no_reading(site, "damaged_answers", fail(Faults(corrupt_rate=1.0)), sound)


def failing_supply(site: Site) -> Fault:
    """Return a fault in which the chip's supply fails again and again."""
    fails = Felt(site.loop.sensor, _failing_supply)
    return no_reading(site, "failing_supply", fails, fails.mend)


def conversions(site: Site, anew_s: float = 0.0) -> Iterator[Fault]:
    """Yield the faults of conversions, and disturbances that must not trip a rule.

    anew_s -- time until the next answer if the chip is set up again after a damaged answer, s.
    """
    frozen = watched(site, "frozen", fail(Faults(frozen=True)), fail(Faults()))
    yield replace(frozen, sensor_lies=True)  # the chip repeats its last reading permanently
    yield _damaged_in_bursts(site, anew_s)
    interrupt = on_chip(SpiChip.brown_out)
    yield harmless(site, "supply_interrupted_once", interrupt, WATCH_S, _zeros_not_believed)


def slow(site: Site) -> Fault:
    """Return the fault of a chip whose conversions take longer than in its data sheet."""
    return slow_conversions(site, fail(Faults(slow=SLOW)), WATCH_S)


def _damaged_in_bursts(site: Site, anew_s: float) -> Fault:
    """Return a chip that damages as many answers in a row as the controller just tolerates.

    A chip that is set up again after a damaged answer gives the next one after a conversion.
    """
    taken = max(1, math.ceil(site.loop.periods_in(anew_s)))
    most = max(1, (steps(site.loop.protection.stale_after_s, site.loop) - 1) // taken)
    return bursts_of_damage(site, chip_of, most, (1 + SOUND_PER_DAMAGED) * most, WATCH_S)


def short(level: Level | None) -> Act:
    """Return an act that shorts the chip's data to a level; None: that removes the short."""
    return on_chip(lambda chip: chip.short(level))


def _failing_supply(world: World) -> Feel:
    """Interrupt the chip's supply in every step of time, so that no conversion ends."""

    def feel(felt_c: float) -> float:
        chip_of(world).brown_out()
        return felt_c

    return feel


def _zeros_not_believed(world: World) -> str:
    """Check that the chip's answer before its first conversion was not used as a temperature."""
    log = world.device.steps(world.site.loop_name)
    lowest_c = float(log["temperature_c"][log["has_reading"] == 1].min())
    return f"{lowest_c:.1f} °C was used as a temperature" if lowest_c == 0.0 else ""
