"""Outputs of which every tick counts: time-proportional ones, and the feed at its driver's pins."""

import math
import random
from collections.abc import Iterator
from itertools import pairwise, product

import numpy as np
import pytest
from numpy.typing import NDArray
from rig.outputs import LATE_S, TICK_S, OutputBoard, Wired, reset_problem, wired

from heatwright.sim.binary.elf import Elf
from heatwright.sim.outputs.stepper import attach
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.outputs.course import SpreadCourse, course_of
from heatwright.sim.reference.outputs.output import heater_of
from heatwright.spec import Stepper, TimeProportionalOutput

FEEDER = "steps: 200, microsteps: 16, lead: 25 mm, maximum: 20 mm/s, acceleration: 50 mm/s²"
STEPS_PER_MM = 128
FASTEST = "steps: 200, microsteps: 16, lead: 25 mm, maximum: 78 mm/s, acceleration: 800 mm/s²"
BOARDS = {
    "nano": "step: D4, direction: D5, enable: D6",  # timer 0, 8 bits
    "leonardo": "step: D4, direction: D5, enable: D6",
    "mega2560": "step: D6, direction: A8, enable: A9",  # ports beyond sbi and cbi
    "atmega1284p": "step: PC0, direction: PC1, enable: PC6, enable_active: high",
    "atmega32": "step: PC0, direction: PC1, enable: PC6, enable_active: high",  # TIMSK is shared
}


def fed(board: str, settings: str = FEEDER) -> Wired:
    return wired(board, {"feed": f"kind: stepper, {BOARDS[board]}, {settings}"})


class Feed(OutputBoard):
    """The feed on a board, its driver and motor simulated; the test is the loop and the host."""

    def __init__(self, place: Wired, elf: Elf | None = None) -> None:
        super().__init__(place, elf)
        output = self.controller.outputs["feed"]
        assert isinstance(output, Stepper)
        self.driver = attach(self.avr, self.board, output)
        self.run(0.1)

    def move(self, steps: int, mm_per_s: float) -> None:
        self.put("feed_speed", mm_per_s)
        self.put("feed_steps", steps)
        self.run(0.02)

    def run(self, seconds: float) -> None:
        self.avr.run(seconds)
        self.driver.feed(self.avr.pins.take(), np.zeros(0))

    def finish(self, most_s: float) -> None:
        """Run until it is at rest: each step was made, and is as the driver's data sheet wants."""
        start = self.avr.time_s
        while self.busy:
            assert self.avr.time_s < start + most_s
            self.run(0.05)
            # It was said at the last tick: 100 steps ago at most.
            assert abs(self.driver.position - self.get("feed_position")) <= 101
        assert (self.driver.violations, self.driver.missed) == (0, 0)
        assert self.driver.position == self.get("feed_position")

    @property
    def busy(self) -> bool:
        return bool(self.get("feed_busy"))

    @property
    def times_s(self) -> NDArray[np.float64]:
        times: NDArray[np.float64] = self.driver.steps["cycle"] / self.avr.clock_hz
        return times


@pytest.fixture
def feed(request: pytest.FixtureRequest) -> Feed:
    """On a nano with the feeder's settings, or as a test says."""
    return Feed(fed(*getattr(request, "param", ("nano",))))


def on_each(*boards: str) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("feed", [(board,) for board in boards], indirect=True)


@pytest.mark.parametrize("feed", [*product(BOARDS, (FEEDER, FASTEST))], indirect=True)
def test_every_step_is_made(feed: Feed) -> None:
    assert not feed.driver.on
    place = 0
    for steps, mm_per_s in ((1, 5), (-3, 20), (5120, 100), (-700, 3), (2, 0.5), (-4420, 12.3)):
        feed.move(steps, mm_per_s)
        assert feed.driver.on
        feed.finish(20.0)
        place += steps
        assert feed.driver.position == place
    assert place == 0


def trapezoid(
    times_s: NDArray[np.float64], length: float, speed: float, acceleration: float
) -> NDArray[np.float64]:
    """Where a move is at these times that speeds up, runs and slows down as it may."""
    ramp_s = speed / acceleration
    up, runs = np.clip(times_s, 0, ramp_s), np.clip(times_s, ramp_s, length / speed) - ramp_s
    left = np.clip(length / speed + ramp_s - times_s, 0, ramp_s)
    return acceleration * (up**2 + ramp_s**2 - left**2) / 2 + speed * runs


@on_each(*BOARDS)
def test_it_goes_along_a_trapezoid(feed: Feed) -> None:
    began_s = feed.avr.time_s
    feed.move(40 * STEPS_PER_MM, 25.0)  # more than it may
    feed.finish(4.0)
    times_s = feed.times_s
    places = np.arange(1, len(times_s) + 1) / STEPS_PER_MM
    # Speed is set once a tick: what it is ahead or behind is a tick at most, and a step.
    allowed = 20.0 * TICK_S + 1 / STEPS_PER_MM
    starts = np.arange(began_s - TICK_S, began_s + 3 * TICK_S, TICK_S / 5)
    off = [abs(trapezoid(times_s - start, 40.0, 20.0, 50.0) - places).max() for start in starts]
    assert min(off) < allowed
    run = times_s[(places > 10) & (places < 30)]
    assert (len(run) - 1) / (run[-1] - run[0]) == pytest.approx(20 * STEPS_PER_MM, rel=1e-5)


def test_speed_changes_by_no_more_than_the_acceleration(feed: Feed) -> None:
    feed.move(40 * STEPS_PER_MM, 20.0)
    speeds = []
    while feed.busy:
        speeds.append(float(feed.get("output_feed.c:steps_per_s")))
        feed.run(TICK_S)
    per_tick = 50 * STEPS_PER_MM * TICK_S
    start = max(per_tick, math.sqrt(50 * STEPS_PER_MM))
    assert speeds[0] <= start + per_tick
    assert np.abs(np.diff(speeds)).max() <= per_tick * 1.00001
    assert max(speeds) == 20 * STEPS_PER_MM
    assert speeds[-1] <= start + 2 * per_tick  # and so it stops within two ticks' change


@pytest.mark.parametrize("feed", [("nano", FEEDER.replace("50 mm", "0.001 mm"))], indirect=True)
def test_with_little_acceleration_it_begins_at_the_slowest_speed(feed: Feed) -> None:
    feed.move(4, 5.0)
    assert float(feed.get("output_feed.c:steps_per_s")) == pytest.approx(1.0, rel=0.01)
    feed.finish(10.0)
    assert feed.driver.position == 4


def test_it_rests_below_the_slowest_speed(feed: Feed) -> None:
    """A step of an hour would need more counts than 32 bits hold."""
    feed.move(30 * STEPS_PER_MM, (10 * 50 * STEPS_PER_MM * TICK_S + 0.01) / STEPS_PER_MM)
    feed.run(1.0)
    feed.put("ready", 0)
    speeds = []
    while not speeds or speeds[-1] > 0:
        feed.run(TICK_S)
        speeds.append(float(feed.get("output_feed.c:steps_per_s")))
    assert len(speeds) > 5
    assert min(speeds[:-1]) >= 1.0


@on_each("nano", "mega2560")
@pytest.mark.parametrize("mm_per_s", [0.0001, 0.0079, 0.05, 0.5, 3.0, 17.77])
def test_any_speed_is_right_in_the_mean(feed: Feed, mm_per_s: float) -> None:
    steps = max(8, round(mm_per_s * STEPS_PER_MM * 4))
    feed.move(steps, mm_per_s)
    feed.finish(30.0)
    times_s = feed.times_s
    a, b = len(times_s) // 4, 3 * len(times_s) // 4
    found = (b - a) / (times_s[b] - times_s[a]) / STEPS_PER_MM
    # A period is a whole number of 1/256 counts; an edge is a count and an interrupt's latency off.
    assert found == pytest.approx(max(mm_per_s, 1 / STEPS_PER_MM), rel=3e-4)


def test_it_waits_for_the_heat_and_goes_on(feed: Feed) -> None:
    feed.put("ready", 0)
    feed.move(30 * STEPS_PER_MM, 20.0)
    feed.run(0.5)
    assert (feed.driver.position, feed.busy) == (0, 1)
    feed.put("ready", 1)
    feed.run(1.0)
    before = feed.driver.position
    feed.put("ready", 0)
    feed.run(20.0 / 50.0 + 3 * TICK_S)
    stopped = feed.driver.position
    # v²/2a more, and a tick of delay and one of coarseness.
    assert stopped - before <= (20.0**2 / 100 + 2 * 20.0 * TICK_S) * STEPS_PER_MM
    feed.run(1.0)
    assert feed.driver.position == stopped < 30 * STEPS_PER_MM
    feed.put("ready", 1)
    feed.finish(4.0)
    assert feed.driver.position == 30 * STEPS_PER_MM


def test_a_stop_slows_down_and_forgets(feed: Feed) -> None:
    feed.move(30 * STEPS_PER_MM, 20.0)
    feed.run(1.0)
    before = feed.driver.position
    feed.put("feed_stop", 1)
    feed.finish(0.6)
    stopped = feed.driver.position
    # v²/2a, less half a tick's way: the speed is set at the beginning of each tick.
    least = (20.0**2 / 100 - 20.0 * TICK_S / 2) * STEPS_PER_MM - 1
    assert least <= stopped - before <= least + 3 * 20.0 * TICK_S * STEPS_PER_MM
    feed.run(1.0)
    assert feed.driver.position == stopped
    feed.move(-stopped, 20.0)
    feed.finish(4.0)
    assert feed.driver.position == 0


def test_a_fault_stops_it_at_once(feed: Feed) -> None:
    feed.move(30 * STEPS_PER_MM, 20.0)
    feed.run(1.0)
    before = feed.driver.position
    feed.put("permitted", 0)
    feed.run(1.0)
    stopped = feed.driver.position
    assert stopped - before <= math.ceil(20 * STEPS_PER_MM * TICK_S)
    assert not feed.driver.on
    assert (feed.busy, feed.get("feed_position")) == (0, stopped)
    feed.put("permitted", 1)
    feed.run(1.0)
    assert feed.driver.position == stopped  # the rest is forgotten
    feed.move(128, 20.0)
    feed.finish(1.0)
    assert feed.driver.position == stopped + 128
    feed.put("fault.code", 6)
    feed.move(128, 20.0)
    feed.run(0.5)
    assert feed.driver.position == stopped + 128


def test_the_motor_is_let_go(feed: Feed) -> None:
    feed.move(-4000, 20.0)
    feed.run(0.5)
    assert feed.driver.on
    feed.put("feed_disable", 1)
    feed.run(0.1)
    assert not feed.driver.on
    feed.finish(0.0)
    made = len(feed.driver.steps)
    feed.move(-100, 20.0)
    feed.finish(1.0)
    # From rest, not at the speed at which it was let go.
    assert np.diff(feed.times_s[made : made + 2])[0] > 1 / (80 + 2 * 64)


def test_moves_the_same_way_are_one(feed: Feed) -> None:
    for _ in range(10):
        feed.move(256, 20.0)
    feed.move(-100, 20.0)  # the other way: not while it runs
    feed.finish(4.0)
    assert feed.driver.position == 2560
    gaps_s = np.diff(feed.times_s)
    middle = gaps_s[(np.arange(len(gaps_s)) > 800) & (np.arange(len(gaps_s)) < 1700)]
    assert middle.max() < 1.1 / (20 * STEPS_PER_MM)  # it does not stop in between


@pytest.mark.parametrize("feed", [*product(("nano", "mega2560"), (FASTEST,))], indirect=True)
def test_interrupts_however_late_lose_no_step_and_no_time(feed: Feed) -> None:
    """Interrupts off for longer than an interval, on a timer soon round and on a long one."""
    for number, deaf_us in enumerate((*range(20, 920, 20), 150), 1):
        feed.put("deaf_us", deaf_us)
        feed.move(1500, 78.0)
        feed.finish(1.5)
        assert feed.driver.position == len(feed.driver.steps) == 1500 * number
        # The first interval of a ramp is the longest, and ends late by as much.
        assert np.diff(feed.times_s[-1500:]).max() <= 1 / 1024 + TICK_S


@pytest.mark.parametrize("feed", [*product(BOARDS, (FASTEST,))], indirect=True)
def test_an_interrupt_is_short(feed: Feed) -> None:
    """20 us at most with interrupts off, the step's own 2 us in it."""
    profile = feed.avr.profile(feed.program)
    feed.move(400, 78.0)
    feed.run(0.1)
    longest = max(found.longest for name, found in profile.functions.items() if "vector" in name)
    assert longest / feed.avr.clock_hz < 20e-6


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
    "burst": BURST, "burst of ticks": "window: 6 s, resolution: 60 ms",
    "short pulses left out": SHORT_LEFT_OUT, "spread": SPREAD,
    "spread of ticks": "window: 10 s, resolution: 100 ms, distribution: spread",
    "spread of many steps": "window: 6 s, resolution: 20 ms, distribution: spread",
}  # fmt: skip

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
