"""Inputs of the machine, beside each interface: contacts that open, bounce and close again."""

import pytest
from fault_machines import judged, site_of
from rig.specs import changed

from heatwright.sim.faults import starts
from heatwright.sim.faults.world import World

INPUTS = "safety:\n  inputs: {{door: {{pin: {}, trips: false, for: 30 ms}}, stop: {{pin: {}}}}}"
EXAMPLES = {
    "chamber": ("A2", "A3"),
    "kiln": ("A4", "A5"),
    "kiln_uno": ("A3", "A4"),
    "printer": ("D41", "A5"),
    "fabricator": ("PD2", "PB4"),
}
"""A panel; a touch display, a menu: both with programs and a relay; a host with two loops; a
master, a cooler, a watched current and a relay. The pins of the door and of the stop."""
KEPT = ("gate.c:input_ticks", "gate.c:air_paused", "inputs.c:found", "inputs.c:stop_ticks")
"""What the firmware keeps of them, in bytes."""


def with_inputs(example: str) -> str:
    return changed(example, ("safety:", INPUTS.format(*EXAMPLES[example])))


CHAMBER = with_inputs("chamber")


@pytest.mark.parametrize("example", EXAMPLES)
@pytest.mark.parametrize(
    ("fault", "rule"),
    [("input_stop_opens", "input_open"), ("input_door_opens", None),
     ("input_stop_bounces", None), ("input_door_bounces", None)],
)  # fmt: skip
def test_nothing_heats_while_one_is_open(example: str, fault: str, rule: str | None) -> None:
    assert judged(with_inputs(example), fault) == rule


def opened(name: str) -> World:
    world = starts.heating(site_of(CHAMBER))
    world.device.contacts[name].move(is_open=True)
    world.run(0.1)
    return world


@pytest.mark.parametrize("variable", KEPT)
@pytest.mark.parametrize("name", ["door", "stop"])
def test_no_flipped_bit_heats_while_one_is_open(name: str, variable: str) -> None:
    world = opened(name)
    place = world.device.variables[variable].address
    for bit in range(8):
        flipped_s = world.now_s
        world.device.avr.flip(place, bit)
        world.run(0.2)
        world.device.feed()
        assert world.heaters.last_on_s(flipped_s) is None


@pytest.mark.parametrize("register", ["PORT", "DDR"])
@pytest.mark.parametrize("is_open", [False, True])
def test_a_pin_s_registers_are_written_anew(register: str, is_open: bool) -> None:
    site = site_of(CHAMBER)
    pin = site.controller.board.pins[site.controller.safety.inputs["stop"].pin]
    world = opened("door") if is_open else starts.heating(site)
    place = world.device.variables[f"{register}{pin.port}"].address
    before = world.device.avr.read_ram(place, 1)[0] & 1 << pin.bit
    world.device.avr.flip(place, pin.bit)
    world.run(0.1)
    assert world.device.avr.read_ram(place, 1)[0] & 1 << pin.bit == before


def test_an_open_contact_outlives_a_loss_of_power() -> None:
    world = opened("stop")
    world.power_cut()
    cut_s = world.power_on_s
    world.run(5.0)
    world.device.feed()
    assert world.heaters.last_on_s(cut_s) is None
    assert world.fault
