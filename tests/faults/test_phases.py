"""A cause may come at any moment of the period, also in the middle of an exchange."""

from collections.abc import Callable

import numpy as np
import pytest
from fault_machines import site_of

from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import TICK_S, answer_s, gate_s, reading_s, watchdog_s
from heatwright.sim.faults.processor import hang
from heatwright.sim.faults.world import World
from heatwright.sim.sensors.ds18b20 import Ds18b20

PHASES_S = (*np.arange(0.0, 1.0, 0.1), 0.2013, 0.2051, 0.9512, 0.9527, 0.9561, 0.9608, 0.9999)
any_phase = pytest.mark.parametrize("phase_s", PHASES_S, ids="{:.4f}".format)
CAUSES: dict[str, tuple[Callable[[Ds18b20], None], int]] = {
    "unplugged": (Ds18b20.unplug, 1),
    "shorted": (lambda chip: chip.short("low"), 2),
    "lifted": (lambda chip: chip.short("high"), 1),
}


def at_phase(phase_s: float) -> tuple[World, Ds18b20, float]:
    """A machine that is heating, at this moment of a period."""
    world = starts.heating(site_of("chamber"))
    at_s = float(np.ceil(world.now_s) + phase_s)
    world.run(at_s - world.now_s)
    world.device.advance(at_s)
    chip = world.device.sensors["air"]
    assert isinstance(chip, Ds18b20)
    return world, chip, at_s


def heated_on_s(world: World, since_s: float) -> float:
    """How long after a moment the heater was on last."""
    last_on_s = world.heaters.last_on_s(since_s)
    assert last_on_s is not None
    return last_on_s - since_s


@any_phase
@pytest.mark.parametrize("cause", CAUSES)
def test_whenever_it_comes(cause: str, phase_s: float) -> None:
    world, chip, at_s = at_phase(phase_s)
    act, code = CAUSES[cause]
    act(chip)
    world.until(lambda now: now.fault != 0, 10.0)
    (trip,) = world.trips.since(0.0)
    assert trip.code == code
    assert trip.time_s - at_s <= answer_s(world.site.loop)
    assert heated_on_s(world, at_s) <= reading_s(world.site.loop)


@any_phase
def test_a_chip_that_browns_out_is_never_believed(phase_s: float) -> None:
    world, chip, _ = at_phase(phase_s)
    chip.brown_out()
    world.run(10.0)
    assert world.fault == 0
    read_c = world.device.steps("air")["temperature_c"]
    assert read_c[read_c > 0].max() < world.peak_c + 1


@pytest.mark.parametrize("phase_s", np.arange(0.0, 0.1, 0.007), ids="{:.3f}".format)
@pytest.mark.parametrize("entry", ["__stop_program", "_exit"])
def test_a_hang_whenever_it_comes(entry: str, phase_s: float) -> None:
    world = starts.heating(site_of("chamber"))
    at_s = world.now_s + phase_s
    world.device.advance(at_s)
    try:
        hang(world, entry)
    except ValueError:  # just awake
        world.device.advance(at_s + TICK_S / 2)
        hang(world, entry)
    limit_s = gate_s() if entry == "__stop_program" else watchdog_s(world.site.controller)
    world.run(3.0)
    assert heated_on_s(world, at_s) <= limit_s + TICK_S / 2
    assert world.fault == 14
