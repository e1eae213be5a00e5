"""Settling time and overshoot, on courses whose every step is known: within 2 K, for 5 s."""

import pytest

from heatwright.sim.reference.algorithms.response import Response
from heatwright.sim.reference.numbers import Single
from heatwright.spec import Loop


class Course:
    """A loop that is measured; its period is half a second, so 5 s are 10 steps."""

    def __init__(self) -> None:
        self.response = Response(2.0, 5.0, Loop.model_construct(period_s=0.5))

    def go(self, setpoint_c: float, *temperatures_c: float | None, held: bool = True) -> None:
        for each in temperatures_c:
            temperature_c = None if each is None else Single(each)
            self.response.step(temperature_c, Single(setpoint_c), held=held)

    def __getitem__(self, name: str) -> float:
        names = [name for name, _ in self.response.members]
        return float(dict(zip(names, self.response.values(), strict=True))[name])

    @property
    def result(self) -> tuple[float, float, float]:
        return self["measured"], self["settling_s"], self["overshoot_k"]


@pytest.fixture
def course() -> Course:
    return Course()


def test_a_step_up_that_overshoots(course: Course) -> None:
    course.go(100, 20, 60, 99, 103.5, 104.25, 101, *9 * [99.5])
    assert course["state"] == 2
    assert course.result == (0, 0, 0)
    course.go(100, 99.5)
    assert course.result == (1, 2.5, 4.25)  # near for good five steps behind the first
    course.go(100, 200)
    assert (course["state"], course.result) == (3, (1, 2.5, 4.25))


def test_a_step_down_counts_what_is_below(course: Course) -> None:
    course.go(50, 52, *10 * [51])
    course.go(40, 51, 45, 37.5, 38, *10 * [42])
    assert course.result == (2, 1.5, 2.5)


def test_the_edge_is_inside(course: Course) -> None:
    course.go(50, *11 * [48])
    assert course.result == (1, 0, 0)
    course.go(60, *11 * [57.9])
    assert course["state"] == 1


def test_a_ramp_is_approached_from_where_it_comes(course: Course) -> None:
    """It reads ahead of the setpoint at the ramp's end, and yet rises."""
    for setpoint_c in range(20, 101):
        course.go(setpoint_c, setpoint_c + 3)
    course.go(100, 103.5, *11 * [101])
    assert course.result == (1, 1.0, 3.5)


def test_missing_readings_take_their_time(course: Course) -> None:
    course.go(50, 20, None, None, 50, *4 * [None], *5 * [50])
    assert course["state"] == 2
    course.go(50, 50)
    assert course.result == (1, 1.5, 0)


def test_what_is_not_held_gives_no_result(course: Course) -> None:
    course.go(50, 20, 50, 50)
    course.go(50, 50, held=False)
    assert course["state"] == 0
    course.go(50, *10 * [50])
    assert course.result == (0, 0, 0)
    course.go(60, 51)
    course.go(70, 51)
    assert (course["state"], course["target_c"], course.result) == (1, 70, (0, 0, 0))


def test_nobody_waits_for_ever(course: Course) -> None:
    course.go(50, *70_000 * [20.0])
    assert course["steps"] == 65535
    course.go(50, *20 * [50.0])
    assert course.result == (0, 0, 0)
