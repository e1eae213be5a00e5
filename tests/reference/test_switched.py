"""A loop that is switched, its cooler, and its master."""

import pytest
from switched_loops import controller_of

from heatwright.sim.reference.loop import Reference
from heatwright.sim.reference.master import Master
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.switched import SwitchedOperator

COLD_C, WARM_C, HOT_C = 20.0, 50.0, 80.0


def test_off_is_off_at_every_setpoint(nozzle):
    nozzle.enabled = 0
    for setpoint_c in (0.0, 50.0, 100.0):
        nozzle.setpoint_c = setpoint_c
        record = nozzle.feed(COLD_C)
        assert (record["duty_percent"], record["cooling"]) == (0, 0)


def test_nought_degrees_is_a_setpoint(nozzle):
    nozzle.setpoint_c = 0.0
    record = nozzle.feed(COLD_C)
    assert (record["duty_percent"], record["cooling"]) == (0, 1)


def test_switching_off_resets_the_algorithm(nozzle):
    assert nozzle.feed(COLD_C)["algorithm.heating"] == 1
    nozzle.enabled = 0
    assert nozzle.feed(COLD_C)["algorithm.heating"] == 0


def test_a_cooler_goes_on_without_a_reading_until_the_loop_is_off(nozzle):
    assert nozzle.feed(HOT_C)["cooling"] == 1
    assert nozzle.feed(HOT_C, 1)["cooling"] == 1
    nozzle.enabled = 0
    assert nozzle.feed(HOT_C, 1)["cooling"] == 0


@pytest.mark.parametrize(
    ("temperature_c", "status", "cooling"),
    [(80.0, 0, 1), (50.0, 0, 1), (49.9375, 0, 0), (49.9375, 1, 1), (80.0, 1, 1)],
)
@pytest.mark.parametrize("enabled", [0, 1])
def test_a_latched_fault_cools_what_is_hot(nozzle, temperature_c, status, cooling, enabled):
    nozzle.enabled = enabled
    nozzle.feed(WARM_C)
    nozzle.reference.stop()
    assert nozzle.feed(temperature_c, status)["cooling"] == cooling


def test_a_lost_master_is_a_fault_while_the_loop_is_on(nozzle):
    record = nozzle.feed(HOT_C, master_lost=True)
    assert (record["fault.code"], record["fault.temperature_c"]) == (23, 80)
    assert record["cooling"] == 1


def test_a_lost_master_is_none_while_the_loop_is_off(nozzle):
    nozzle.enabled = 0
    assert nozzle.feed(HOT_C, master_lost=True)["fault.code"] == 0


def test_the_master_is_asked_after_first(nozzle):
    nozzle.feed(WARM_C)
    nozzle.amperes = 10.0
    record = nozzle.feed(119.0, master_lost=True)
    assert (record["fault.code"], record["current.leak_steps"]) == (23, 0)


class Operated:
    """A master's side of the loop."""

    def __init__(self):
        controller = controller_of()
        self.reference = Reference(controller, "nozzle")
        self.operator = SwitchedOperator(controller, "nozzle", self.reference)
        self.master = Master(controller, "nozzle", self.operator, self.reference)

    def write(self, name, value):
        self.master.write(name, value)
        return self.operator.orders.enabled

    def step(self):
        self.reference.step(0, 320, self.operator.setpoint_c, orders=self.operator.orders)
        self.operator.after_step()


@pytest.fixture
def operated():
    return Operated()


def test_on_needs_an_off_before(operated):
    operator = operated.operator
    assert not operator.enable()
    operator.disable()
    assert operator.enable()
    assert operator.enable()
    operated.step()
    assert operator.orders.enabled == 1


def test_an_off_is_taken_over_before_the_on_behind_it(operated):
    operator = operated.operator
    for last, now in ((0, 1), (1, 0)):
        assert operator.orders.enabled == last
        operator.disable()
        assert operator.enable()
        assert operator.orders.enabled == now
        operated.step()
    assert operator.orders.enabled == 1


def test_a_fault_asks_for_another_off(operated):
    operator = operated.operator
    operator.switch(on=True)
    operated.step()
    operated.reference.stop()
    operated.step()
    operator.acknowledge()
    assert operator.orders.enabled == 0
    assert not operator.enable()
    operator.disable()
    assert operator.enable()


def test_an_off_while_the_fault_is_latched_will_do(operated):
    operator = operated.operator
    operated.reference.stop()
    operated.step()
    operator.disable()
    assert not operator.enable()
    operator.acknowledge()
    assert operator.enable()


def test_a_master_with_a_switch_does_both(operated):
    operated.write("nozzle.enabled", value=True)
    operated.step()
    assert operated.operator.orders.enabled == 1
    assert operated.write("nozzle.enabled", value=False) == 0


def test_setpoints_keep_to_their_limits_and_switch_nothing(operated):
    operated.write("nozzle.setpoint", 100.0)
    operated.write("nozzle.setpoint", 100.1)
    operated.write("nozzle.setpoint", -0.1)
    assert operated.operator.setpoint_c == Single(100)
    assert operated.write("nozzle.setpoint", 0.0) == 0
    assert operated.operator.setpoint_c == Single(0)


def test_a_setpoint_is_taken_while_a_fault_is_latched(operated):
    operated.reference.stop()
    operated.write("nozzle.setpoint", 70.0)
    assert operated.operator.setpoint_c == Single(70)


@pytest.mark.parametrize("name", ["other.setpoint", "nozzle.colour", "reboot"])
def test_what_there_is_not_cannot_be_written(operated, name):
    with pytest.raises(KeyError):
        operated.write(name, 1.0)
