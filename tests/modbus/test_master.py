"""The simulated master on the binary: it reads, writes by name, is refused, and judges the line."""

import pytest
from modbus_wire import CALM, powered
from rig.specs import controller_of

from heatwright.sim.device import AvrDevice
from heatwright.sim.interfaces import modbus_frames as frames
from heatwright.sim.interfaces.modbus_rtu import POLL_S

ROOM_C = 45.0
REGISTER_K = 0.1
LOST, EARLY_S = 23, 0.5


def slave(name: str, *replaced: tuple[str, str], at_s: float = 1.5) -> AvrDevice:
    _, device = powered(name, None, *replaced)
    device.advance(at_s)
    return device


def run(device: AvrDevice, seconds: float) -> None:
    device.advance(device.time_s + seconds)


@pytest.mark.parametrize("name", ["fabricator", "dryer"])
def test_it_polls_by_itself(name: str) -> None:
    device = slave(name, at_s=10.2)
    master = device.master
    assert master.polls == 2 * 10
    assert (master.unanswered, master.strangers, master.damaged) == (0, 0, 0)
    assert master.values["uptime"] == 10
    controller = controller_of(name)
    ((loop, spec),) = controller.loops.items()
    step_k = controller.thermometers[spec.sensor].step_at_k(ROOM_C, controller.board.mcu)
    reads_c = pytest.approx(ROOM_C, abs=step_k + REGISTER_K / 2)
    assert master.values[f"{loop}.temperature"] == reads_c
    assert master.slowest_s <= 0.005
    assert master.longest_gap_s < 1.5 * master.bus.form.bits / master.bus.baud


def test_what_it_writes_arrives_and_it_shows_a_loop_the_change_from_off_to_on() -> None:
    device = slave("dryer")
    for name, value in {"air.setpoint": 62.5, "air.kp": 12.25, "air.manual_duty": 33.3}.items():
        device.write(name, value)
    run(device, 1.0)
    assert device.read("settings.air_setpoint_c") == 62.5
    assert device.read("settings.air_kp") == 12.25
    for _ in range(2):
        device.write("air.enabled", True)
        run(device, 1.0)
        assert device.read("loop_air.enabled") == 1
        assert device.read("modbus_counters.exceptions") == 1
    device.write("air.manual", True)
    run(device, 2.0)
    assert device.master.values["air.duty"] == pytest.approx(33.3)
    assert device.master.refusals == []
    assert not device.master.is_busy


@pytest.mark.parametrize(
    ("name", "value"), [("air.setpoint", 80.1), ("air.manual", True), ("air.kp", float("nan"))]
)
def test_it_is_told_what_is_refused(name: str, value: float) -> None:
    device = slave("dryer")
    device.write(name, value)
    run(device, 1.0)
    assert [(each.name, each.exception) for each in device.master.refusals] == [(name, 3)]


def test_a_lost_master_is_a_fault_that_it_acknowledges() -> None:
    device = slave("dryer", *CALM["dryer"])
    device.write("air.enabled", True)
    run(device, 2.0)
    device.unplug()
    run(device, 30.0 - EARLY_S)
    assert device.read("fault.code") == 0
    run(device, POLL_S + EARLY_S)
    assert device.read("fault.code") == LOST
    assert device.read("loop_air.duty_percent") == 0
    device.master.plug()
    run(device, 1.0)
    assert device.master.fault == LOST
    device.write("acknowledge", True)
    run(device, 2.0)
    assert device.master.fault == 0
    assert device.master.values["acknowledgements"] == 1
    assert device.read("loop_air.enabled") == 0
    assert device.master.refusals == []


@pytest.mark.parametrize(
    ("address", "setpoint_c", "unanswered"), [(0, 123.4, 0), (2, 30, 1)], ids=["all", "another"]
)
def test_nobody_answers_for_all_or_for_another(
    address: int, setpoint_c: float, unanswered: int
) -> None:
    device = slave("fabricator")
    asked = device.master.ask(frames.write_register(100, 1234), address=address)
    run(device, 2.5)
    assert asked.done
    assert asked.answer is None
    assert device.read("settings.nozzle_setpoint_c") == pytest.approx(setpoint_c)
    assert (device.master.unanswered, device.master.strangers) == (unanswered, 0)
    assert device.master.values["unanswered"] == 1 - unanswered


def test_a_power_cut_leaves_the_master_where_it_was() -> None:
    device = slave("dryer")
    device.unplug()
    device.power_cycle()
    run(device, 5.0)
    assert device.master.polls == 0
    device.master.plug()
    run(device, 3.0)
    assert device.master.polls > 0


def test_it_does_not_know_what_is_not_there() -> None:
    with pytest.raises(LookupError, match=r"no nozzle\.kp"):
        slave("fabricator").write("nozzle.kp", 1.0)
