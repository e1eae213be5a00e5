"""The arithmetic of the timing: grids, ticks, keys, texts."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from rig.firmware import changed, controller_of, device_of

from heatwright.sim.interfaces.lcd import Screen
from heatwright.sim.timing.display import button_to_display, to_come
from heatwright.sim.timing.figures import Figure
from heatwright.sim.timing.operator import Press, aimed, presses
from heatwright.sim.timing.stage import Stage, resting_c
from heatwright.sim.timing.steps import deviations_us, jitter, longest_tick
from heatwright.spec import Controller, facts_of, longest_wait_s

CLOCK_HZ = 1_000_000


def cycles(*values: int) -> NDArray[np.uint64]:
    return np.array(values, np.uint64)


def test_steps_are_held_to_the_grid_of_the_first() -> None:
    entries = cycles(500, 1_000_500, 2_000_490, 3_000_520)
    assert deviations_us(entries, 1.0, CLOCK_HZ).tolist() == [0, 0, -10, 20]
    figure = jitter(entries, 1.0, CLOCK_HZ, "air")
    assert (figure.worst, figure.details["spread"]) == (20, 30)
    assert figure.passed


def test_a_lost_step_is_off_by_a_period_and_none_at_all_does_not_pass() -> None:
    figure = jitter(cycles(0, 1_000_000, 3_000_000), 1.0, CLOCK_HZ, "air")
    assert (figure.worst, figure.passed) == (1e6, False)
    assert not jitter(cycles(), 1.0, CLOCK_HZ, "air").passed
    assert Figure("", "ms", 50.0, 50.0).passed, "a limit is still within"
    assert not Figure("", "ms", 50.1, 50.0).passed


def test_the_longest_tick() -> None:
    for begins, ends, ticks, worst in (
        # The work of a tick begins with the interrupt.
        ((1005, 2005, 3005), (0, 1100, 2400, 3100), (999, 1000, 2000, 3000), 400),
        # A tick that comes during the work of the one before waits for it.
        ((1000, 2000, 3000), (0, 2300, 2900, 3100), (1000, 2000, 3000), 1300),
    ):
        figure = longest_tick(cycles(*begins), cycles(*ends), cycles(*ticks), 10**6)
        assert (figure.worst, figure.limit, figure.passed) == (worst, 1000, worst <= 1000)


def test_keys_are_timed_to_the_complete_text() -> None:
    shown = ((0.0, "", 19), (1.03, "", 29), (1.04, "", 20), (1.10, "x", 20), (2.03, "x", 21))
    screens = [Screen(at_s, (first, f"Set temp {celsius}°C")) for at_s, first, celsius in shown]
    figure = button_to_display([Press(1.0, "up", 20.0), Press(2.0, "up", 21.0)], screens)
    assert (figure.worst, figure.details["median"]) == (pytest.approx(40), pytest.approx(35))
    assert figure.passed


def test_a_display_of_whole_degrees_rounds() -> None:
    shown = ((0.0, "289°C"), (1.02, "279°C"), (1.03, "278°C"), (2.03, "289°C"))
    screens = [Screen(at_s, ("Setpoint", row)) for at_s, row in shown]
    pressed = [Press(1.0, "down", 278.2), Press(2.0, "up", 288.5), Press(3.0, "up", 288.8)]
    figure = button_to_display(pressed, screens)
    assert (figure.worst, figure.details["not_shown"]) == (pytest.approx(30), 0)


@pytest.mark.parametrize("row", ["Set temp 19°C", "Set temp 29°C", "E06 TOO HOT", ""])
def test_a_wrong_text_is_no_answer(row: str) -> None:
    screens = [Screen(0.0, ("", "Set temp 19°C")), Screen(1.03, ("", row))]
    figure = button_to_display([Press(1.0, "up", 20.0)], screens)
    assert figure.worst is None
    assert not figure.passed


def test_keys_meet_steps_and_refreshes_at_every_phase() -> None:
    """What comes regularly is continued."""
    assert to_come([0.1], 99) == [0.1]
    assert to_come([0.1, 30.0, 60.0], 130) == [0.1, 30.0, 60.0, 90.0, 120.0]
    steps = [0.5 + each for each in range(600)]
    refreshes = [30.1 * each for each in range(20)]
    times = np.array(aimed(600, steps, refreshes))
    assert (np.diff(times) > 0.3).all()
    assert np.histogram(times % 0.01, 10, (0, 0.01))[0].min() > 0.5 * len(times) / 10
    for aims, least in ((steps, 100), (refreshes, 10)):
        off = (times[:, None] - np.array(aims)[None, :]).ravel()
        near = off[(off >= -0.045) & (off <= 0.010)]
        assert len(near) >= least
        assert near.min() < -0.035
        assert near.max() > 0


def test_keys_change_the_setpoint_both_ways_within_its_limits(chamber: Controller) -> None:
    keypad = facts_of(chamber).keypad
    assert keypad is not None
    pressed = presses(chamber, keypad, [float(each) for each in range(40)])
    limits = chamber.loops["air"].setpoint
    setpoints = [limits.initial_c, *(press.setpoint_c for press in pressed)]
    assert all(limits.minimum_c <= each <= limits.maximum_c for each in setpoints)
    for press, before in zip(pressed, setpoints, strict=False):
        assert press.setpoint_c - before == (10 if press.key == "up" else -10)
    assert {press.key for press in pressed} == {"up", "down"}


def test_down_is_not_pressed_at_the_lowest_setpoint_which_would_switch_off() -> None:
    tenths = ("initial: 20 °C, minimum: 10 °C", "initial: 10.3 °C, minimum: 10 °C")
    controller = controller_of(changed("chamber", tenths, ("step: 10 K", "step: 0.1 K")))
    keypad = facts_of(controller).keypad
    assert keypad is not None
    pressed = presses(controller, keypad, [float(each) for each in range(40)])
    before = [10.3, *(press.setpoint_c for press in pressed)]
    downs = [at for at, press in zip(before, pressed, strict=False) if press.key == "down"]
    assert min(downs) > 10.05
    assert len(downs) > 10


NARROW = ("minimum: 10 °C, maximum: 70 °C", "minimum: 20 °C, maximum: 39 °C")


@pytest.mark.parametrize("above", ["10 K", "25 K"])
def test_a_wide_step_is_taken_back_where_the_machine_would_have_to_heat(above: str) -> None:
    wide = ("step: 10 K", "step: 15 K"), ("above: 10 K", f"above: {above}")
    controller = controller_of(changed("chamber", NARROW, *wide))
    keypad = facts_of(controller).keypad
    assert keypad is not None
    pressed = presses(controller, keypad, [5 + 0.5 * each for each in range(40)])
    assert {press.setpoint_c for press in pressed} == {20.0, 35.0}
    after_s = np.diff([press.time_s for press in pressed])
    assert after_s.min() > 0.3
    assert bool(after_s[::2].max() < 0.4) is (resting_c(controller, "air") < 35)
    assert (resting_c(controller, "air") < 35) is (above == "10 K")


@pytest.mark.parametrize(
    ("machine", "wait_us"),
    [
        (("hotplate",), 100),
        (("chamber",), 50),  # its DS18B20
        (("kiln",), 1e7 / 115_200),  # its log's line
        (("extruder",), 40),  # PWM by interrupts
        (("printer", ("baud: 115200", "baud: 250000")), 40),  # what is sent to it,
    ],
)
def test_interrupts_wait_as_long_as_what_they_serve_bears(
    machine: tuple[Any, ...], wait_us: float
) -> None:
    name, *changes = machine
    assert 1e6 * longest_wait_s(controller_of(changed(name, *changes))) == pytest.approx(wait_us)


def test_a_loop_that_no_key_moves_rests_at_its_setpoint() -> None:
    """At the multiple of ten below, it would heat for ever: heating_failed tripped anyway."""
    text = changed(
        "chamber",
        ("initial: 20 °C", "initial: 34 °C"),
        ("  - {kind: lcd_keypad, loop: air, step: 10 K}\n", ""),
        ("    - {at: 10 s, press: up, times: 3}\n", ""),
    )
    device = device_of(text)
    Stage(controller_of(text), device, 150.0).advance(150.0)
    assert device.read("fault.code") == 0
