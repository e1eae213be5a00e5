"""What goes on without a jump when a host changes its mind, and what it must not leave out."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference_machines import Commanded, commanded_of, kiln_of

from heatwright.sim.reference import Reference
from heatwright.sim.reference.inputs import AUTOMATIC
from heatwright.sim.reference.numbers import Single

SINGLE = 2**-22
"""A few roundings of numbers up to some hundreds, relatively."""


@given(st.integers(-64, 64), st.integers(-4, 4), st.floats(0, 100, width=32))
def test_the_return_from_manual_does_not_jump(sixteenths, slope, percent):
    """As long as the integral's limits let it follow."""
    loop = Commanded(commanded_of())
    loop.by_hand(percent)
    base_c = 50 + sixteenths / 16
    records = loop.feed_all([base_c - slope / 16, base_c])
    assert records[-1]["duty_percent"] == Single(percent)
    loop.mode = AUTOMATIC
    before = records[-1]
    inside = 0 < before["algorithm.integral"] < 100
    after = loop.feed(base_c)  # the slope has ended: take its part out of the comparison
    drop = 8 * (float(before["algorithm.derivative"]) - float(after["algorithm.derivative"]))
    expected = percent - drop + 0.5 * -sixteenths / 16
    if inside and 0 < expected < 100:
        assert after["duty_percent"] == pytest.approx(expected, abs=100 * SINGLE)


@given(
    st.lists(st.integers(-32, 32), min_size=2, max_size=5),
    st.floats(0.5, 20, width=32),
    st.floats(0.5, 20, width=32),
)
def test_new_gains_do_not_jump(sixteenths, kp, kd):
    temperatures_c = [50 + n / 16 for n in sixteenths]
    loop = Commanded(commanded_of())
    loop.feed_all(temperatures_c)
    twin = Commanded(commanded_of())
    twin.feed_all(temperatures_c)
    twin.set_gains(kp, 0.5, kd)
    old, new = loop.feed(50.0), twin.feed(50.0)
    inside = 0 < new["algorithm.integral"] < 100 and 0 < old["algorithm.integral"] < 100
    if inside and 0 < old["duty_percent"] < 100:
        assert new["duty_percent"] == pytest.approx(old["duty_percent"], abs=300 * SINGLE)
        assert new["algorithm.kp"] == Single(kp)


def test_a_tunable_loop_needs_its_gains():
    loop = Commanded(commanded_of())
    loop.gains = None
    with pytest.raises(ValueError, match="gains"):
        loop.feed(45.0)


def test_a_critical_temperature_must_be_told():
    adjustable = kiln_of(protection="maximum_adjustable: true")
    with pytest.raises(ValueError, match="critical temperature"):
        Reference(adjustable, "air").step(0, 0, Single(0))
