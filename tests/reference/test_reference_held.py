"""Minimum times of an output, in ticks and in time."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatwright.sim.reference.course import course_of
from heatwright.sim.reference.held import Held, HeldCourse
from heatwright.spec import DigitalOutput

ORDERS = st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), max_size=200)
"""Asked, permitted, and stopped, in each tick."""


def course(held: Held, orders: list[tuple[bool, bool, bool]]) -> list[bool]:
    found = []
    for asked, permitted, stopped in orders:
        found.append(held.tick(permitted=permitted))
        held.set(asked=asked)
        if stopped:
            held.stop()
    return found


@given(ORDERS, st.integers(0, 20), st.integers(0, 20))
def test_it_is_never_on_or_off_for_less_than_the_minimum(orders, minimum_on, minimum_off):
    """But for what is not permitted or stopped, which is off at once."""
    on_in_tick = course(Held(minimum_on, minimum_off), orders)
    for on, (_, permitted, _) in zip(on_in_tick, orders, strict=True):
        assert permitted or not on
    pauses = "".join("10"[not on] for on in on_in_tick).split("1")[:-1]
    assert all(len(pause) >= minimum_off for pause in pauses[1:] if pause)
    assert not pauses or len(pauses[0]) >= minimum_off - 1  # the tick that switches is its end
    free = course(Held(minimum_on, minimum_off), [(asked, True, False) for asked, *_ in orders])
    pulses = "".join("10"[not on] for on in free).split("0")[:-1]
    assert all(len(pulse) >= minimum_on for pulse in pulses if pulse)


@given(ORDERS)
def test_without_minimum_times_it_is_what_was_asked_for(orders):
    found = course(Held(0, 0), orders)
    before = [(False, True, False), *orders]
    for on, (asked, _, stopped), (_, permitted, _) in zip(found, before, orders, strict=False):
        assert on == (asked and permitted and not stopped)


def test_in_time_it_goes_by_ticks():
    run = HeldCourse(Held(5, 3))
    run.apply(1)
    assert run.advance(30_000) == 0  # off for three ticks, the third switches on
    run.apply(0)
    assert run.advance(100_000) == 50_000
    run.apply(1)
    assert run.advance(115_000) == 5_000  # the pause began at 80 ms


def test_an_output_with_minimum_times_has_such_a_course(vary):
    output = DigitalOutput.model_validate(
        {"kind": "digital", "pin": "D3", "power": "240 W", "minimum_on": "2 s"}
    )
    run = course_of(vary(output=output), "heater")
    run.apply(1)
    run.advance(1_000_000)
    run.apply(0)
    assert run.advance(3_000_000) == pytest.approx(1_010_000)
