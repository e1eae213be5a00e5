"""The current of a heater: what it is, what it may be, what is wrong with it."""

import pytest
from switched_loops import STEP_A, Nozzle, controller_of

from heatwright.sim.reference import Reference
from heatwright.sim.reference.inputs import Orders
from heatwright.sim.reference.numbers import Single

COLD_C, WARM_C = 20.0, 50.0
TWO_AMPERES = 25.0


def duties(nozzle, count=6):
    return [float(nozzle.feed(COLD_C)["duty_percent"]) for _ in range(count)]


def amperes_of(raw, controller=None):
    step = Reference(controller or controller_of(), "nozzle").step
    return step(0, 320, Single(50), orders=Orders(current_raw=raw))["current.amperes"]


def test_amperes_are_the_middle_of_the_step():
    assert amperes_of(400) == Single(STEP_A / 4) * Single(400) + Single(STEP_A / 2)


def test_an_offset_does_not_make_negative_amperes():
    controller = controller_of()
    sensor = controller.sensors["current"].model_copy(update={"offset_v": 2.5})
    moved = controller.model_copy(update={"sensors": {**controller.sensors, "current": sensor}})
    assert amperes_of(0, moved) == Single(0)
    assert amperes_of(4 * 512, moved) == pytest.approx(STEP_A / 2)


def test_a_heater_begins_softly():
    assert duties(Nozzle()) == [25, 50, 75, 100, 100, 100]


def test_without_a_limit_it_does_not():
    assert duties(Nozzle(controller_of("{sensor: current, trip: 3 A}"))) == [100] * 6


def test_a_wire_of_less_resistance_is_held_to_the_limit(nozzle):
    nozzle.ohm = TWO_AMPERES / 3
    found = duties(nozzle, 20)
    assert found[0] == 25
    # 6 A at full duty: 2.5 A are five twelfths of it
    assert found[-1] == pytest.approx(100 * 2.5 / 6, abs=100 * STEP_A / 6)
    assert max(found) * 6 / 100 < 1.25 * 2.5


def test_off_it_begins_anew(nozzle):
    duties(nozzle)
    nozzle.feed(WARM_C)
    assert float(nozzle.feed(WARM_C)["current.limit_percent"]) == 25
    assert duties(nozzle, 2) == [25, 50]


def test_what_was_asked_is_kept_apart_from_what_is_given():
    record = Nozzle().feed(COLD_C)
    assert (record["asked_percent"], record["duty_percent"]) == (100, 25)


def test_over_current_trips_at_once(nozzle):
    duties(nozzle)
    nozzle.ohm = TWO_AMPERES / 2
    assert nozzle.feed(COLD_C)["fault.code"] == 20


def test_a_leak_trips_after_five_steps(nozzle):
    nozzle.feed(WARM_C)
    nozzle.amperes = 0.3
    number, record = nozzle.until_fault(WARM_C)
    assert (number, record["fault.code"], record["current.leak_steps"]) == (5, 21, 5)


def test_five_per_cent_of_the_limit_is_no_current(nozzle):
    nozzle.amperes = 0.05 * 2.5 - STEP_A
    for _ in range(20):
        assert nozzle.feed(WARM_C)["current.leak_steps"] == 0
    nozzle.amperes = 0.05 * 2.5 + STEP_A
    assert nozzle.feed(WARM_C)["current.leak_steps"] == 1


def test_a_gap_in_a_leak_begins_the_count_anew(nozzle):
    for amperes in (0.3, 0.3, 0.3, 0.3, 0.0, 0.3):
        nozzle.amperes = amperes
        record = nozzle.feed(WARM_C)
    assert (record["fault.code"], record["current.leak_steps"]) == (0, 1)


def test_a_broken_wire_trips_after_five_steps(nozzle):
    duties(nozzle)
    nozzle.amperes = 0.9
    number, record = nozzle.until_fault(COLD_C)
    assert (number, record["fault.code"], record["current.none_steps"]) == (5, 22, 5)


def test_more_than_half_of_what_is_due_is_a_current(nozzle):
    duties(nozzle)
    nozzle.amperes = 1.1
    assert nozzle.feed(COLD_C)["current.none_steps"] == 0


def test_a_current_is_watched_without_a_reading_too(nozzle):
    nozzle.feed(WARM_C)
    nozzle.amperes = 4.0
    assert nozzle.feed(WARM_C, 1)["fault.code"] == 20


def test_while_a_fault_is_latched_the_current_goes_on_and_the_counts_rest(nozzle):
    nozzle.feed(WARM_C)
    nozzle.amperes = 0.3
    nozzle.until_fault(WARM_C)
    nozzle.amperes = 0.7
    record = nozzle.feed(WARM_C)
    assert (record["current.leak_steps"], record["current.none_steps"]) == (0, 0)
    assert float(record["current.amperes"]) == pytest.approx(0.7, abs=STEP_A)


def test_the_step_that_trips_leaves_the_rest_as_it_was(nozzle):
    duties(nozzle)
    nozzle.amperes = 0.9
    nozzle.feed(COLD_C)
    nozzle.amperes = 10.0
    record = nozzle.feed(COLD_C)
    assert (record["fault.code"], record["current.none_steps"]) == (20, 1)
