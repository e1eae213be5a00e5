"""A loop that a master switches, and the current of its heater."""

import pytest
from reference_machines import STEP_A, nozzle_of

from heatwright.sim.reference.inputs import Orders
from heatwright.sim.reference.loop import Reference
from heatwright.sim.reference.master import Master
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.switched import SwitchedOperator


class Operated:
    """A master's side of the loop."""

    def __init__(self):
        controller = nozzle_of()
        self.reference = Reference(controller, "nozzle")
        self.operator = SwitchedOperator(controller, "nozzle", self.reference)
        self.write = Master(controller, "nozzle", self.operator, self.reference).write

    @property
    def enabled(self):
        return self.operator.orders.enabled

    def step(self):
        self.reference.step(0, 320, self.operator.setpoint_c, orders=self.operator.orders)
        self.operator.after_step()


@pytest.fixture
def operated():
    return Operated()


def test_on_needs_an_off_before_which_is_taken_over_before_the_on_behind_it(operated):
    operator = operated.operator
    assert not operator.enable()
    for last, now in ((0, 1), (1, 0)):
        assert operated.enabled == last
        operator.disable()
        assert operator.enable()
        assert operator.enable()
        assert operated.enabled == now
        operated.step()
    assert operated.enabled == 1


def test_a_fault_asks_for_another_off_and_one_while_it_is_latched_will_do(operated):
    operator = operated.operator
    operator.switch(on=True)
    operated.step()
    for off_while_latched in (False, True):
        operated.reference.stop()
        operated.step()
        if off_while_latched:
            operator.disable()
            assert not operator.enable()
        operator.acknowledge()
        assert operated.enabled == 0
        assert operator.enable() is off_while_latched
        operator.disable()
        assert operator.enable()


def test_a_master_switches_and_sets_within_limits(operated):
    operated.write("nozzle.enabled", value=True)
    operated.step()
    assert operated.enabled == 1
    operated.write("nozzle.enabled", value=False)
    assert operated.enabled == 0
    for written, taken in ((100.0, 100), (100.1, 100), (-0.1, 100), (0.0, 0)):
        operated.write("nozzle.setpoint", written)
        assert operated.operator.setpoint_c == Single(taken)
    operated.reference.stop()
    operated.write("nozzle.setpoint", 70.0)
    assert operated.operator.setpoint_c == Single(70)
    assert operated.enabled == 0


@pytest.mark.parametrize("name", ["other.setpoint", "nozzle.colour", "reboot"])
def test_what_there_is_not_cannot_be_written(operated, name):
    with pytest.raises(KeyError):
        operated.write(name, 1.0)


def amperes_of(raw, controller=None):
    step = Reference(controller or nozzle_of(), "nozzle").step
    return step(0, 320, Single(50), orders=Orders(current_raw=raw))["current.amperes"]


def test_amperes_are_the_middle_of_the_step():
    assert amperes_of(400) == Single(STEP_A / 4) * Single(400) + Single(STEP_A / 2)


def test_an_offset_does_not_make_negative_amperes():
    controller = nozzle_of()
    sensor = controller.sensors["current"].model_copy(update={"offset_v": 2.5})
    moved = controller.model_copy(update={"sensors": {**controller.sensors, "current": sensor}})
    assert amperes_of(0, moved) == Single(0)
    assert amperes_of(4 * 512, moved) == pytest.approx(STEP_A / 2)
