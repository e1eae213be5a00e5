"""The EEPROM damaged, or a record of it cut short by a loss of power; a setpoint in RAM damaged."""

from __future__ import annotations

import random
from collections.abc import Iterator
from importlib import import_module
from types import ModuleType

from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import answer_s, start_up_s
from heatwright.sim.faults.fault import Fault, Trip
from heatwright.sim.faults.readings import SENSOR_RULES
from heatwright.sim.faults.site import OfState
from heatwright.sim.faults.world import STEP_S, Site, World

SEED = 1
WATCH_S = 30.0
HIGHEST_BIT = 7
"""Of a byte; of the third of a float it is the last of the exponent."""
BYTES = 7
"""Of a record, after which the power goes: half of the shortest."""
REST_S = 2.0
LONGEST_MS = 1000


def faults(site: Site) -> Iterator[Fault]:
    """Yield what can happen to any EEPROM."""
    yield Fault(
        "eeprom_damaged",
        lambda: starts.heating(site),
        damage,
        trip=Trip(("settings_corrupt",), start_up_s(site.controller)),
    )
    yield Fault(
        "setpoint_flipped",
        lambda: starts.heating(site),
        flip_setpoint,
        trip=Trip(("memory_damaged",), 2 * site.loop.period_s),
    )
    if site.has_operator:
        yield Fault(
            "record_cut_short",
            lambda: latched(site),
            cut_short,
            may=SENSOR_RULES,
            sensor_lies=True,
            calm=True,
            watch_s=WATCH_S,
        )


def damage(world: World) -> None:
    """Fill the EEPROM with random bytes while the power is off."""
    noise = random.Random(SEED)  # noqa: S311 - noise, not a secret
    world.device.avr.eeprom.contents = noise.randbytes(world.device.avr.eeprom.size)
    world.power_cut(STEP_S)


def flip_setpoint(world: World) -> None:
    """Flip a bit of the setpoint in the RAM: it becomes twice as far from 0 °C, or half."""
    place = world.device.variables[f"settings.{world.site.loop_name}_setpoint_c"]
    world.device.avr.flip(place.address + place.size - 2, HIGHEST_BIT)


def latched(site: Site) -> World:
    """Begin with a fault that is latched, stored, and whose cause has gone."""
    world = starts.heating(site)
    cut_line(world)
    world.until(OfState(lambda now: now.fault != 0), answer_s(site.loop))
    world.run(REST_S)
    mend_line(world)
    return world


def cut_line(world: World) -> None:
    """Take the loop's sensor from the controller, in the way of its kind."""
    _of_sensor(world.site).cut(world)


def mend_line(world: World) -> None:
    """Give it back."""
    _of_sensor(world.site).mend(world)


def _of_sensor(site: Site) -> ModuleType:
    kind = site.controller.sensors[site.loop.sensor].kind
    return import_module(f"heatwright.sim.faults.sensors.{kind}")


def cut_short(world: World) -> None:
    """Acknowledge, and cut the power in the middle of the record that says so."""
    eeprom = world.device.avr.eeprom
    before = eeprom.writes
    world.hand.begin_acknowledging(world)
    for _ in range(LONGEST_MS):
        world.device.advance(world.now_s + 0.001)
        if eeprom.writes >= before + BYTES and eeprom.writing:
            break
    world.power_cut(STEP_S, undefined=random.Random(SEED).randrange(256))  # noqa: S311 - as above
