"""Faults of a DS18B20: its cable, its supply and its conversions."""

from collections.abc import Iterator
from dataclasses import replace
from typing import cast

from heatwright.sim.faults.bounds import answer_s
from heatwright.sim.faults.fault import Fault, Trip, harmless, watched
from heatwright.sim.faults.sensing.converter import fail, on_chip, short
from heatwright.sim.faults.sensing.readings import (
    SENSOR_RULES,
    bursts_of_damage,
    no_reading,
    slow_conversions,
)
from heatwright.sim.faults.world import Site, Weather, World
from heatwright.sim.reference.numbers import steps
from heatwright.sim.sensors.ds18b20 import Ds18b20, Faults

WATCH_S = 120.0


def cut(world: World) -> None:
    """Short the line to ground."""
    _chip(world).short("low")


def mend(world: World) -> None:
    """Remove the short."""
    _chip(world).short(None)


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the loop's DS18B20."""
    yield from _answers(site)
    frozen = watched(site, "frozen", fail(Faults(frozen=True)), fail(Faults()))
    yield replace(frozen, sensor_lies=True)  # the chip repeats its last reading permanently
    yield _never_converts(site)
    yield from _harmless(site)


def _chip(world: World) -> Ds18b20:
    return cast("Ds18b20", world.device.sensors[world.site.loop.sensor])


def _answers(site: Site) -> Iterator[Fault]:
    """Yield a chip that does not answer, or answers badly: the heater then goes off at once."""
    yield no_reading(site, "unplugged", on_chip(Ds18b20.unplug), on_chip(Ds18b20.plug))
    yield no_reading(site, "shorted_to_ground", short("low"), short(None))
    yield no_reading(site, "shorted_to_supply", short("high"), short(None))
    yield no_reading(site, "damaged_answers", fail(Faults(corrupt_rate=1.0)), fail(Faults()))
    yield no_reading(site, "failing_supply", fail(Faults(weak=True)), fail(Faults()))


def _never_converting(world: World) -> None:
    """Reset the chip to its power-on value, and stop its conversions."""
    fail(Faults(idle=True))(world)
    _chip(world).brown_out()


def _never_converts(site: Site) -> Fault:
    """Return a chip that answers its power-on value from the start, with a correct CRC."""
    return Fault(
        "never_converts",
        lambda: World(site, Weather(site.ambient_c, site.ambient_c)),
        _never_converting,
        fail(Faults()),
        trip=Trip(SENSOR_RULES, answer_s(site.loop)),
        sensor_lies=True,
        again=True,
        judge=_never_believed,
    )


def _harmless(site: Site) -> Iterator[Fault]:
    """Yield disturbances that a long cable causes: they must not trip a rule of the sensor."""
    # The controller just tolerates this number of damaged answers in a row.
    most = steps(site.loop.protection.stale_after_s, site.loop) - 1
    yield bursts_of_damage(site, _chip, most, most + 2, WATCH_S)
    interrupt = on_chip(Ds18b20.brown_out)
    yield harmless(site, "supply_interrupted_once", interrupt, WATCH_S, _never_believed)
    yield slow_conversions(site, fail(Faults(slow=1.5)), WATCH_S)


def _never_believed(world: World) -> str:
    """Check that the chip's power-on value was never used as a temperature."""
    log, name = world.device.steps(world.site.loop_name), world.site.loop.sensor
    highest_c = float(log["temperature_c"].max())
    _, tips_c = world.told(name)
    if highest_c > tips_c.max() + world.site.controller.thermometers[name].step_k:
        return f"the power-on value {highest_c:.1f} °C was used as a temperature"
    return ""
