"""Time-proportional outputs: each tick of each window, in one piece or spread, at either level."""

import random
from collections.abc import Iterator
from itertools import pairwise

import pytest
from rig.outputs import LATE_S, TICK_S, OutputBoard, Wired, reset_problem, wired

from heatwright.sim.binary.elf import Elf
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.outputs.course import SpreadCourse, course_of
from heatwright.sim.reference.outputs.output import heater_of
from heatwright.spec import TimeProportionalOutput

BURST = "window: 1 s, resolution: 10 ms"
SHORT_LEFT_OUT = f"{BURST}, minimum_on: 50 ms, minimum_off: 100 ms"
SPREAD = "window: 2 s, resolution: 20 ms, distribution: spread"


def windows(window: str, active: str, board: str = "uno", pin: str = "D3") -> Wired:
    said = f"kind: time_proportional, pin: {pin}, active: {active}, power: 40 W, {window}"
    return wired(board, {"heater": said})


class WindowBoard(OutputBoard):
    def __init__(self, place: Wired, elf: Elf | None = None) -> None:
        super().__init__(place, elf)
        output = self.controller.outputs["heater"]
        assert isinstance(output, TimeProportionalOutput)
        self.output = output
        self.heater = self.outputs["heater"]
        self.avr.run(TICK_S + LATE_S)
        self.avr.pins.take()
        self.switched = 0
        self._last = self.heater.on

    def tick(self) -> bool:
        """Go on to just after the next tick; say whether it is on."""
        self.avr.run(TICK_S)
        for change in self.changes():
            self.switched += change.on != self._last
            self._last = change.on
        return self.heater.on


def duties(seed: int, most_ticks: int, count: int) -> Iterator[tuple[float, int]]:
    drawn = random.Random(seed)  # noqa: S311 - no secret
    for _ in range(count):
        percent = drawn.choice([0.0, 100.0, 1.0, 99.0, 50.0, drawn.uniform(0, 100)])
        yield percent, drawn.randint(1, most_ticks)


def problem(bench: WindowBoard, asked: Iterator[tuple[float, int]]) -> str:
    """Say where a course of duties, each for some ticks, is not what it should be."""
    counts, course = heater_of(bench.controller, "heater"), course_of(bench.controller, "heater")
    number, due_switched, last = 0, bench.switched, bench.heater.on
    for percent, ticks in asked:
        bench.ask("heater", percent)
        for late in range(ticks):
            number += 1
            seen, due = bench.tick(), course.advance(10_000 * number) > 0
            if seen != due:
                return f"tick {number}, {percent} %: {seen}, not {due}"
            due_switched, last = due_switched + (seen != last), seen
            if late == 0:
                counts.apply(Single(percent))
                course.apply(counts.counts)
                if bench.get("output_heater.on_steps") != counts.counts:
                    return f"{percent} % are {bench.get('output_heater.on_steps')} steps"
    if bench.switched != due_switched:
        return f"{bench.switched} changes of the pin, not {due_switched}"
    return ""


def closed_problem(bench: WindowBoard) -> str:
    """Say whether a closed gate, or an order for nothing, leaves it on."""
    for percent in (100.0, 60.0):
        bench.ask("heater", percent)
        on = [bench.tick() for _ in range(300)]
        bench.put("permitted", 0)
        if not any(on) or any(bench.tick() for _ in range(300)):
            return "on with the gate closed"
        if not bench.heater.driven:
            return "not driven"
        bench.put("permitted", 1)
        if not any(bench.tick() for _ in range(300)):
            return "not on again"
        bench.ask("heater", 0.0)
        if bench.tick() and bench.tick():
            return "zero waits for the window's end"
        if any(bench.tick() for _ in range(300)):
            return "on at zero"
    return ""


def whole_problem(place: Wired, elf: Elf | None = None) -> str:
    late = WindowBoard(place, elf)
    for _ in range(7):
        late.tick()  # the first window begins with the first duty, whenever that comes
    first = WindowBoard(place, elf)
    ticks = round(first.output.window_s / TICK_S)
    duties_behind = (50.0, 2.0, 99.0, 4.0, 5.0, 6.0, 89.0, 90.0, 91.0, 40.0)
    behind = [(30.0, ticks + 1), *((each, ticks) for each in duties_behind)]
    return (
        problem(first, iter(behind))  # each duty comes behind the first tick of a window
        or problem(late, duties(2, 400, 25))
        or closed_problem(WindowBoard(place, elf))
    )


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


@pytest.mark.parametrize("on_steps", range(101))
def test_the_reference_s_pulses_are_as_many_as_asked_for_and_evenly_spread(on_steps: int) -> None:
    """In two windows of 100 steps; the gaps are of at most two lengths, one apart."""
    course = SpreadCourse(100, 1)
    course.apply(on_steps)
    steps = [course.advance(step + 1) > 0 for step in range(200)]
    assert sum(steps) == 2 * on_steps
    gaps = {after - before for before, after in pairwise(n for n, on in enumerate(steps) if on)}
    assert not gaps or max(gaps) - min(gaps) <= 1
