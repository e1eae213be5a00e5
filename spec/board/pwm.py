"""PWM that the timers can make: by their own compare outputs, or by interrupts at any pin."""

from collections.abc import Collection, Iterator
from typing import NamedTuple

from heatwright.spec.boards import Board, Timer
from heatwright.spec.outputs import PwmOutput

FREQUENCY_TOLERANCE = 0.005
"""Tolerance of an Uno's ceramic resonator: a PWM frequency cannot be more accurate."""

FEWEST_COUNTS = 100
"""Minimum number of steps of a PWM period: one step is then at most 1 % of the power."""

FASTEST_BY_INTERRUPTS_HZ = 500.0
"""Maximum, as its two interrupts a period, some 100 cycles each, use 0.6 % of a 16 MHz clock."""

MOST_COUNTS_BY_INTERRUPTS = (1 << 15) - 1
"""Longest PWM period, half the range of a free-running 16-bit timer: an edge that is up to a period
late is then not mistaken for a future edge."""

LATEST_INTERRUPT_S = 50e-6
"""How late an interrupt may come, after other interrupts; that of a 1-Wire slot is the longest.
Pulses and pauses that are shorter cannot be made, and are left out."""


class PwmSetting(NamedTuple):
    """How a timer makes a PWM: `counts` counts of clock/`prescaler` to a period."""

    prescaler: int
    counts: int
    frequency_hz: float


def pwm_settings(clock_hz: int, timer: Timer) -> Iterator[PwmSetting]:
    """List an 8-bit timer's settings: 256 counts of each prescaled clock, the fastest first."""
    for prescaler in timer.prescalers:
        counts = 1 << timer.bits
        yield PwmSetting(prescaler, counts, clock_hz / (prescaler * counts))


def pwm_setting(board: Board, output: PwmOutput) -> PwmSetting:
    """Find the setting nearest to the output's frequency, on the timer of its pin.

    An 8-bit timer counts to 256 (fast PWM, mode 3); a 16-bit one to any number (mode 14), here with
    the smallest prescaler that makes the period, for the finest steps.

    Raises ValueError: the pin has no timer.
    """
    pin = board.pins[output.pin]
    if pin.pwm is None:
        raise ValueError(f"{output.pin} has no compare output")
    timer = board.timers[pin.pwm[0]]
    if timer.bits == 8:
        settings = pwm_settings(board.clock_hz, timer)
        return min(settings, key=lambda each: _distance(each.frequency_hz, output.frequency_hz))
    for prescaler in timer.prescalers:
        counts = round(board.clock_hz / (prescaler * output.frequency_hz))
        if counts < 1 << timer.bits:
            break
    counts = min(max(counts, FEWEST_COUNTS), (1 << timer.bits) - 1)
    return PwmSetting(prescaler, counts, board.clock_hz / (prescaler * counts))


def _distance(frequency_hz: float, wanted_hz: float) -> float:
    """How far apart two frequencies are, as a ratio of at least 1."""
    return max(frequency_hz / wanted_hz, wanted_hz / frequency_hz)


def keeps_frequency(setting: PwmSetting, wanted_hz: float) -> bool:
    """Return whether a setting's frequency is within a resonator's tolerance of the wanted one."""
    return _distance(setting.frequency_hz, wanted_hz) <= 1 + FREQUENCY_TOLERANCE


def settings_by_interrupts(
    clock_hz: int, timer: Timer, frequencies_hz: Collection[float]
) -> tuple[PwmSetting, ...]:
    """Make several frequencies with one free-running 16-bit timer, each on a channel of its own.

    The smallest prescaler that keeps every period within MOST_COUNTS_BY_INTERRUPTS serves all.
    Empty if there is none, or if it leaves a period too few counts or an inexact frequency.
    """
    for prescaler in timer.prescalers:
        settings = tuple(
            PwmSetting(prescaler, counts, clock_hz / (prescaler * counts))
            for counts in (round(clock_hz / (prescaler * each)) or 1 for each in frequencies_hz)
        )
        if all(each.counts <= MOST_COUNTS_BY_INTERRUPTS for each in settings):
            fine = all(
                made.counts >= FEWEST_COUNTS and keeps_frequency(made, wanted_hz)
                for made, wanted_hz in zip(settings, frequencies_hz, strict=True)
            )
            return settings if fine else ()
    return ()
