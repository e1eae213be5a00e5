"""A critical temperature that the operator lowers."""

import pytest
from programmed_kiln import Kiln, controller_of

from heatwright.sim.reference import Reference
from heatwright.sim.reference.numbers import Single

ADJUSTABLE = "maximum_adjustable: true"


@pytest.fixture
def kiln():
    return Kiln(controller_of(protection=ADJUSTABLE))


def test_it_is_the_specs_at_first(kiln):
    assert kiln.feed(1099.9921875)["guard.maximum_c"] == 1100.0
    assert kiln.record["fault.code"] == 0


def test_it_trips_where_the_operator_has_put_it(kiln):
    assert kiln.operator.set_critical(500.0)
    assert kiln.feed(499.9921875)["fault.code"] == 0
    assert kiln.feed(500.0)["fault.code"] == 6


@pytest.mark.parametrize("maximum_c", [-0.5, 1100.5])
def test_there_are_limits(kiln, maximum_c):
    assert not kiln.operator.set_critical(maximum_c)
    assert kiln.feed(20.0)["guard.maximum_c"] == 1100.0


def test_others_have_none():
    kiln = Kiln()
    assert not kiln.operator.set_critical(500.0)
    assert "guard.maximum_c" not in kiln.feed(20.0)


def test_a_step_must_be_told():
    with pytest.raises(ValueError, match="critical temperature"):
        Reference(controller_of(protection=ADJUSTABLE), "air").step(0, 0, Single(0))
