"""Time-proportional outputs: each tick of each window, in one piece or spread, at either level."""

from itertools import pairwise

import pytest
from rig.outputs import first_lines, reset_problem
from window_course import (
    BURST,
    SHORT_LEFT_OUT,
    SPREAD,
    WindowBoard,
    closed_problem,
    duties,
    problem,
    whole_problem,
    windows,
)

from heatwright.sim.reference.course import SpreadCourse

PLACES = [("uno", "D3"), ("mega2560", "D2"), ("mega2560", "D9"), ("atmega32", "PC0")]
"""A port beyond the reach of `sbi` among them."""
WINDOWS = {
    "burst": BURST,
    "burst of ticks": "window: 6 s, resolution: 60 ms",
    "short pulses left out": SHORT_LEFT_OUT,
    "spread": SPREAD,
    "spread of ticks": "window: 10 s, resolution: 100 ms, distribution: spread",
    "spread of many steps": "window: 6 s, resolution: 20 ms, distribution: spread",
}

either_level = pytest.mark.parametrize("active", ["high", "low"])


@either_level
@pytest.mark.parametrize("window", WINDOWS)
def test_every_tick_is_as_it_should_be(window: str, active: str) -> None:
    bench = WindowBoard(windows(WINDOWS[window], active))
    most = 5 * round(bench.output.window_s / 0.01) // 2
    assert problem(bench, duties(1, most, 12)) == ""


@pytest.mark.parametrize("window", [SPREAD, SHORT_LEFT_OUT])
def test_no_duty_comes_at_a_wrong_moment(window: str) -> None:
    assert whole_problem(windows(window, "low")) == ""


@either_level
@pytest.mark.parametrize(("board", "pin"), PLACES)
@pytest.mark.parametrize("window", [BURST, SPREAD])
def test_the_gate_and_a_reset_force_it_off(board: str, pin: str, window: str, active: str) -> None:
    bench = WindowBoard(windows(window, active, board, pin))
    assert closed_problem(bench) == ""
    bench.ask("heater", 100.0)
    assert any(bench.tick() for _ in range(300))
    assert reset_problem(bench, "heater") == ""


@either_level
def test_the_first_instructions_set_the_level_before_they_drive_it(active: str) -> None:
    """A pin that were driven first would be low for two cycles: on, where low is active."""
    lines = first_lines(windows(SPREAD, active))
    assert lines[-2:] == ["pin_output_heater_off();", "pin_output_heater_drive();"]


def spread(on_steps: int, windows: int) -> list[bool]:
    """Let the reference spread so many of 100 steps over each window of 2 s, tick by tick."""
    course = SpreadCourse(100, 20_000)
    course.advance(500_000)
    course.apply(on_steps)
    ticks = range(200 * windows)
    return [course.advance(500_000 + 10_000 * (tick + 1)) > 0 for tick in ticks]


@pytest.mark.parametrize("on_steps", range(101))
def test_the_reference_s_pulses_are_as_many_as_asked_for_and_evenly_spread(on_steps: int) -> None:
    """The gaps between them are of at most two lengths, one apart."""
    steps = spread(on_steps, 2)[::2]
    assert sum(steps) == 2 * on_steps
    gaps = {after - before for before, after in pairwise(n for n, on in enumerate(steps) if on)}
    assert not gaps or max(gaps) - min(gaps) <= 1


def test_the_reference_spreads_alike() -> None:
    bench = WindowBoard(windows(SPREAD, "high"))
    bench.ask("heater", 37.0)
    bench.tick()
    assert [bench.tick() for _ in range(400)] == spread(37, 2)
