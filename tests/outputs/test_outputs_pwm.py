"""Pulse width at the pins: every compare output of every chip, and any pin by interrupts."""

from collections.abc import Iterator

import numpy as np
import pytest
from pwm_course import (
    CLOCK_HZ,
    LATENCY,
    PwmBoard,
    gate_problem,
    heater_problems,
    placed,
    pwm,
    restart_problem,
)
from rig.outputs import Wired, first_lines, reset_problem

from heatwright.spec import BOARDS
from heatwright.spec.pwm import FREQUENCY_TOLERANCE, LATEST_INTERRUPT_S

CHIPS = ("uno", "mega2560", "leonardo", "atmega1284p", "atmega32", "atmega16")

either_level = pytest.mark.parametrize("active", ["high", "low"])


def timers() -> Iterator[tuple[str, int, tuple[str, ...]]]:
    """Every timer with compare outputs of each chip, and their pins."""
    for board in CHIPS:
        pins = {pin.port_name: pin for pin in BOARDS[board].pins.values() if pin.pwm}
        for number in BOARDS[board].timers:
            found = tuple(pin.name for pin in pins.values() if pin.pwm and pin.pwm[0] == number)
            yield board, number, found


@pytest.mark.parametrize(("board", "number", "pins"), list(timers()))
@either_level
def test_every_compare_output(board: str, number: int, pins: tuple[str, ...], active: str) -> None:
    wide = BOARDS[board].timers[number].bits == 16
    said = f"frequency: {1000 if wide else 976.5625} Hz, active: {active}"
    outputs = {f"fan_{pin.lower()}": f"{pin}, {said}" for pin in pins}
    bench = pwm(board, **outputs)
    for name in outputs:
        channel = bench.channels[name]
        assert (channel.timer, channel.by_interrupts) == (number, False)
        switch = bench.outputs[name]
        assert switch.driven
        assert not switch.on  # off is forced from the start on
        for percent in (0.4, 25.0, 50.0, 99.6):
            assert bench.wrong(name, percent, 0.02) == ""
        for percent in (100.0, 0.0, 50.0, 0.0):
            assert bench.wrong(name, percent, 0.02) == ""
            assert percent == 50.0 or switch.on == (percent > 0)


@pytest.mark.parametrize(
    ("board", "pin", "frequency_hz", "by_interrupts"),
    [
        ("uno", "D9", 30, False), ("uno", "D10", 122, False), ("uno", "D9", 31_000, False),
        ("uno", "D3", 62_500, False), ("uno", "D3", 30, True), ("uno", "D4", 122, True),
        ("uno", "A5", 1, True), ("nano", "D5", 500, True),
        ("mega2560", "D46", 30, False), ("mega2560", "D8", 122, False),
        ("mega2560", "D5", 31_000, False),
        # RAMPS: the hotend, and its fan; ports H and K take several instructions.
        ("mega2560", "D10", 30, True), ("mega2560", "D9", 122, True), ("mega2560", "A8", 250, True),
        ("leonardo", "D9", 122, False), ("leonardo", "D5", 31_000, False),
        ("leonardo", "D6", 30, True),  # its own timer, the fourth, is left out
        ("atmega1284p", "PB6", 30, False), ("atmega1284p", "PD4", 31_000, False),
        ("atmega1284p", "PB3", 122, True), ("atmega1284p", "PA5", 499, True),
        ("atmega32", "PD5", 30, False), ("atmega32", "PD4", 31_000, False),
        # Timer 2 divides by 128, timer 0 does not.
        ("atmega32", "PD7", 488.28125, False), ("atmega32", "PB3", 488.28125, True),
        ("atmega16", "PB3", 62_500, False), ("atmega16", "PA5", 122, True),
    ],
)  # fmt: skip
@either_level
def test_frequency_and_share(
    board: str, pin: str, frequency_hz: float, by_interrupts: bool, active: str
) -> None:
    bench = pwm(board, fan=f"{pin}, frequency: {frequency_hz} Hz, active: {active}")
    assert bench.channels["fan"].by_interrupts == by_interrupts
    shortest = 5 + LATEST_INTERRUPT_S * frequency_hz * 100 * by_interrupts
    for percent in (shortest, 33.3, 100 - shortest):
        assert bench.wrong("fan", percent, max(0.05, 12 / frequency_hz)) == ""
    pulses = bench.seen("fan", max(0.05, 12 / frequency_hz))
    found_hz = CLOCK_HZ / pulses.periods.mean()
    assert found_hz == pytest.approx(frequency_hz, rel=FREQUENCY_TOLERANCE)
    assert bench.outputs["fan"].driven


@pytest.mark.parametrize("percent", [0.0, 0.5, 99.7, 100.0])
def test_by_interrupts_too_short_is_none(percent: float) -> None:
    """At 122 Hz 50 us are 0.61 %."""
    bench = pwm(fan="D4, frequency: 122 Hz")
    bench.ask("fan", 50.0)
    bench.ask("fan", percent)
    assert bench.seen("fan", 0.1).share == round(percent / 100)
    assert bench.outputs["fan"].on == (percent > 50)


@pytest.mark.parametrize(
    ("board", "pins", "timer"), [("mega2560", ("D10", "D9"), 5), ("atmega32", ("PC0", "PC1"), 1)]
)
def test_two_on_one_timer_keep_apart(board: str, pins: tuple[str, str], timer: int) -> None:
    hot, part = f"{pins[0]}, frequency: 30 Hz", f"{pins[1]}, frequency: 122 Hz, active: low"
    bench = pwm(board, hot=hot, part=part)
    assert {channel.timer for channel in bench.channels.values()} == {timer}
    bench.ask("hot", 20.0)
    bench.ask("part", 70.0)
    for name, share in (("hot", 0.2), ("part", 0.7)):
        pulses = bench.seen(name, 1.0)
        assert abs(pulses.periods - bench.cycles_of(name)).max() <= 2 * LATENCY
        assert pulses.widths.mean() / pulses.periods.mean() == pytest.approx(share, abs=0.002)
    bench.ask("hot", 0.0)
    assert bench.seen("hot", 0.5).share == 0
    assert bench.seen("part", 0.5).share == pytest.approx(0.7, abs=0.01)


@pytest.mark.parametrize("deaf_us", [25, 300, 1500, 2000])
@pytest.mark.parametrize("percent", [3.0, 50.0, 97.0])
def test_a_late_interrupt_costs_no_more_than_it_is_late(deaf_us: int, percent: float) -> None:
    """Every tick interrupts are off for so long; and 2 ms are a whole period at 500 Hz.

    No part of the firmware has them off for longer than 20 us.
    """
    bench = pwm(fan="D4, frequency: 500 Hz")
    bench.put("deaf_us", deaf_us)
    bench.ask("fan", percent)
    pulses = bench.seen("fan", 3.0)
    deaf = deaf_us * CLOCK_HZ / 1e6
    whole = bench.cycles_of("fan")
    wanted = percent / 100 * whole
    # Who sleeps through a pause goes on with the next pulse.
    more = deaf if deaf < whole - wanted else whole
    assert pulses.widths.max() <= wanted + more + 2 * LATENCY
    assert len(pulses.periods) > 3.0 / (2 * (0.01 + deaf_us / 1e6))
    bench.put("deaf_us", 0)
    bench.avr.run(0.05)
    assert bench.seen("fan", 1.0).share == pytest.approx(percent / 100, abs=0.01)


@pytest.mark.parametrize(("board", "pin"), [("uno", "D4"), ("mega2560", "A8"), ("atmega32", "PC0")])
def test_an_interrupt_is_short(board: str, pin: str) -> None:
    """20 us at most with interrupts off."""
    bench = pwm(board, fan=f"{pin}, frequency: 490 Hz")
    profile = bench.avr.profile(bench.program)
    for percent in (3.0, 50.0, 97.0):
        bench.ask("fan", percent)
        bench.avr.run(0.1)
    longest = max(found.longest for name, found in profile.functions.items() if "vector" in name)
    assert longest / CLOCK_HZ < 20e-6
    assert profile.masked.seconds < 20e-6


def test_no_interrupts_while_nothing_changes() -> None:
    bench = pwm(fan="D4, frequency: 490 Hz")
    awake = {}
    for percent in (50.0, 0.0, 100.0):
        bench.ask("fan", percent)
        before = bench.avr.cycle - bench.avr.sleep_cycles
        bench.avr.run(1.0)
        awake[percent] = bench.avr.cycle - bench.avr.sleep_cycles - before
    assert awake[0.0] == pytest.approx(awake[100.0], rel=0.01)
    per_edge = (awake[50.0] - awake[0.0]) / (2 * 490)
    assert 0 < per_edge < LATENCY + 50
    assert np.isfinite(per_edge)


@pytest.mark.parametrize(("pin", "frequency"), [("D3", "488.28125 Hz"), ("D4", "122 Hz")])
def test_a_higher_supply_is_on_for_less(pin: str, frequency: str) -> None:
    """A heater for 12 V on 18 V: full power is 44.4 % of the time."""
    bench = pwm(heater=f"{pin}, frequency: {frequency}, power: 40 W, supply: 18 V, rated: 12 V")
    for percent in (100.0, 50.0, 10.0):
        bench.ask("heater", percent)
        pulses = bench.seen("heater", 0.2)
        share = pulses.widths.mean() / pulses.periods.mean()
        assert share == pytest.approx(percent / 100 * (12 / 18) ** 2, abs=1 / 256)


@pytest.mark.parametrize("said", ["D4, frequency: 490 Hz", "D3, frequency: 976.5625 Hz"])
def test_nothing_is_wrong_with_a_heater(said: str) -> None:
    assert not any(heater_problems(placed("uno", {"heater": f"{said}, power: 40 W"})))


HEATERS = {
    "timer 2": ("uno", "D3", "976.5625 Hz"),
    "timer 1": ("nano", "D9", "1 kHz"),
    "timer 0": ("leonardo", "D3", "976.5625 Hz"),
    "timer 4": ("mega2560", "D8", "1 kHz"),
    "timer 3": ("atmega1284p", "PB6", "1 kHz"),
    "timer 0 of old": ("atmega32", "PB3", "976.5625 Hz"),
    "timer 1 of old": ("atmega16", "PD5", "1 kHz"),
    "timer 2 of old": ("atmega16", "PD7", "976.5625 Hz"),
    "interrupts": ("uno", "D4", "100 Hz"),
    "interrupts of old": ("atmega32", "PC0", "100 Hz"),
    "interrupts, far port": ("mega2560", "D9", "122 Hz"),
}


def heated(name: str, active: str) -> Wired:
    board, pin, frequency = HEATERS[name]
    said = f"{pin}, frequency: {frequency}, active: {active}, power: 40 W"
    return placed(board, {"heater": said})


@pytest.mark.parametrize("name", HEATERS)
@either_level
def test_off_is_a_level_that_is_forced(name: str, active: str) -> None:
    """By the gate, by zero, and by the first instructions, with a reset or without one."""
    bench = PwmBoard(heated(name, active))
    assert gate_problem(bench) == ""
    bench.ask("heater", 60.0)
    assert bench.seen("heater", 0.1).share > 0.5
    assert reset_problem(bench, "heater") == ""
    assert restart_problem(bench) == ""


@pytest.mark.parametrize("name", HEATERS)
@either_level
def test_what_the_first_instructions_are(name: str, active: str) -> None:
    lines = first_lines(heated(name, active))
    assert lines[-2:] == ["pin_output_heater_off();", "pin_output_heater_drive();"]
    assert ("TCCR" in lines[0]) == ("interrupts" not in name)
