"""Time-proportional outputs: each tick of each window, in one piece or spread, at either level."""

import itertools
import random
from collections.abc import Iterator

import pytest
from output_firmware import sources_of
from window_firmware import Broken, WindowBoard, closed_problem, problem

from heatwright.sim.native.pins import pin_number
from heatwright.sim.reference.course import SpreadCourse

PINS = {"uno": "D3", "mega2560": "D2", "mega2560, far port": "D9", "atmega32": "PC0"}
WINDOWS = {
    "burst": "window: 1 s, resolution: 10 ms",
    "burst of ticks": "window: 6 s, resolution: 60 ms",
    "short pulses left out": "window: 1 s, resolution: 10 ms, minimum_on: 50 ms, "
    "minimum_off: 100 ms",
    "spread": "window: 2 s, resolution: 20 ms, distribution: spread",
    "spread of ticks": "window: 10 s, resolution: 100 ms, distribution: spread",
    "spread of many steps": "window: 6 s, resolution: 20 ms, distribution: spread",
}
FIRST = 40
"""Cycles from the reset vector to the heater's pin, some ten instructions on."""


def said(pin: str, window: str, active: str) -> str:
    return f"kind: time_proportional, pin: {pin}, active: {active}, power: 40 W, {window}"


def duties(seed: int, most_ticks: int, count: int) -> Iterator[tuple[float, int]]:
    """Draw duties, some at the ends, each for some time."""
    drawn = random.Random(seed)  # noqa: S311 - no secret
    for _ in range(count):
        percent = drawn.choice([0.0, 100.0, 1.0, 99.0, 50.0, drawn.uniform(0, 100)])
        yield percent, drawn.randint(1, most_ticks)


@pytest.mark.parametrize("active", ["high", "low"])
@pytest.mark.parametrize("window", WINDOWS)
def test_every_tick_is_as_it_should_be(window: str, active: str) -> None:
    bench = WindowBoard("uno", said("D3", WINDOWS[window], active))
    most = 5 * round(bench.output.window_s / 0.01) // 2
    assert problem(bench, duties(1, most, 12)) == ""


@pytest.mark.parametrize("active", ["high", "low"])
@pytest.mark.parametrize("board", PINS)
@pytest.mark.parametrize("window", ["burst", "spread"])
def test_the_gate_and_a_reset_force_it_off(board: str, window: str, active: str) -> None:
    bench = WindowBoard(board.partition(",")[0], said(PINS[board], WINDOWS[window], active))
    assert closed_problem(bench) == ""
    bench.ask(100.0)
    assert any(bench.tick() for _ in range(300))
    bench.avr.reset()
    bench.avr.pins.take()
    reset_at = bench.avr.cycle
    bench.avr.run(0.2)
    assert not bench.heater.on
    assert bench.heater.driven
    events = bench.avr.pins.take()
    mine = events[events["pin"] == pin_number(bench.heater.pin)]
    # The board's resistor first, then the program, and never the load.
    assert mine["cycle"][-1] - reset_at <= FIRST
    assert ((mine["state"] & 1 == 1) == (active == "low")).all()


@pytest.mark.parametrize("active", ["high", "low"])
def test_the_first_instructions_set_the_level_before_they_drive_it(active: str) -> None:
    """A pin that were driven first would be low for two cycles: on, where low is active."""
    first = sources_of("uno", {"heater": said("D3", WINDOWS["spread"], active)}, "reset")
    lines = first["reset.c"].partition("heaters_off")[2].partition("}")[0].splitlines()[2:]
    assert [line.strip() for line in lines][-2:] == [
        "pin_output_heater_off();",
        "pin_output_heater_drive();",
    ]


@pytest.mark.parametrize("on_steps", range(101))
def test_spread_gives_what_burst_gives_and_no_long_gap(on_steps: int) -> None:
    """Pulses of a window: as many as asked for, and gaps of at most two lengths, one apart."""
    on = [step * on_steps % 100 < on_steps for step in range(100)]
    assert sum(on) == on_steps
    places = [step for step in range(200) if on[step % 100]]
    gaps = {after - before for before, after in itertools.pairwise(places)}
    assert not gaps or max(gaps) - min(gaps) <= 1


def test_the_reference_spreads_alike() -> None:
    course = SpreadCourse(100, 20_000)
    course.advance(500_000)
    course.apply(37)
    bench = WindowBoard("uno", said("D3", WINDOWS["spread"], "high"))
    bench.ask(37.0)
    bench.tick()
    seen = [bench.tick() for _ in range(400)]
    due = [course.advance(500_000 + 10_000 * (tick + 1)) > 0 for tick in range(400)]
    assert seen == due


SPREAD = [
    Broken("heater", "spread < on_steps)", "spread <= on_steps)"),
    Broken("heater", "permitted && spread", "spread"),
    Broken("heater", "OUTPUT_HEATER_WINDOW_STEPS - on_steps", "OUTPUT_HEATER_WINDOW_STEPS"),
    Broken("heater", "window_step = 0;\n        spread = 0;", "window_step = 0;"),
    Broken("heater", "window_step = 0;", ""),
    Broken("heater", "spread < off_steps", "spread <= off_steps"),
    Broken("heater", "spread + on_steps", "spread + on_steps + 1u"),
    Broken("heater", "spread - off_steps", "spread - off_steps + 1u"),
    Broken("heater", "step_tick = 0;", ""),
    Broken("heater", "window_step++;", ""),
    Broken("heater", "window_step == 0 && step_tick == 0", "step_tick == 0"),
    Broken("heater", "window_step == 0 && step_tick == 0", "window_step == 0"),
    Broken("heater", "            on_steps = 0;", ""),
    Broken("heater", "if (running) {", "if (true) {"),
    Broken("heater", "running = true;", ""),
    Broken("heater", "pin_output_heater_off();", ""),
]
BURST = [
    Broken("heater", "permitted && window_tick", "window_tick"),
    Broken("heater", "window_tick < on_ticks)", "window_tick <= on_ticks)"),
    Broken("heater", "if (window_tick == 0) {", "if (true) {"),
    Broken("heater", "            on_ticks = 0;", ""),
    Broken("heater", "if (running) {", "if (true) {"),
    Broken("heater", "        window_tick = 0;", ""),
    Broken("heater", "steps < OUTPUT_HEATER_MINIMUM_ON_STEPS", "false"),
    Broken("heater", "steps > OUTPUT_HEATER_WINDOW_STEPS", "steps == UINT16_MAX"),
    Broken("heater", "pin_output_heater_off();", ""),
]


def spread_problem(broken: Broken | None) -> str:
    return _problem(WINDOWS["spread"], broken)


def burst_problem(broken: Broken | None) -> str:
    return _problem(WINDOWS["short pulses left out"], broken)


def _problem(window: str, broken: Broken | None) -> str:
    def bench() -> WindowBoard:
        return WindowBoard("uno", said("D3", window, "low"), broken)

    late = bench()
    for _ in range(7):
        late.tick()  # the first window begins with the first duty, whenever that comes
    first = bench()
    ticks = round(first.output.window_s / 0.01)
    behind = [(30.0, ticks + 1), *((each, ticks) for each in (50.0, 2.0, 99.0, 40.0))]
    return (
        problem(late, duties(2, 400, 25))
        or problem(first, iter(behind))  # each duty comes behind the first tick of a window
        or closed_problem(bench())
    )


@pytest.mark.parametrize("judge", [spread_problem, burst_problem])
def test_nothing_is_wrong_with_the_whole(judge) -> None:  # type: ignore[no-untyped-def]
    assert judge(None) == ""


@pytest.mark.parametrize(
    ("judge", "broken"),
    [*((spread_problem, each) for each in SPREAD), *((burst_problem, each) for each in BURST)],
    ids=lambda each: f"{each.right[:40]} -> {each.wrong[:40]}" if isinstance(each, Broken) else "",
)
def test_what_is_broken_is_seen(judge, broken: Broken) -> None:  # type: ignore[no-untyped-def]
    assert judge(broken) != ""
