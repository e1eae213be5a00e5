"""Who gets which timer: the tick, the 1-Wire lines, the PWM outputs; and what PWM they can make.

A PWM output has no choice: its pin belongs to a timer. Of the rest the tick chooses first, for a
16-bit timer counts 10 ms in one interrupt where an 8-bit one needs several; each 1-Wire line then
takes a timer of its own, an 8-bit one if it can, for its slots are short.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from heatwright.spec.boards import Board, Timer
from heatwright.spec.controller import Controller
from heatwright.spec.outputs import PwmOutput
from heatwright.spec.sensors import Ds18b20

TICK_S = 0.01
"""The firmware's tick; every period and time-out is a whole number of ticks."""

FREQUENCY_TOLERANCE = 0.005
"""What an Uno's ceramic resonator keeps of its own frequency: a PWM cannot be held closer."""

FEWEST_COUNTS = 100
"""Steps of a PWM period: one step is then at most 1 % of the power."""

MOST_DIVIDER = 255
"""Interrupts of the timer in one tick, counted in a byte."""


class Interval(NamedTuple):
    """A compare match every `counts` counts of clock/`prescaler`, `divider` of them to a tick."""

    prescaler: int
    counts: int
    divider: int


class PwmSetting(NamedTuple):
    """How a timer makes a PWM: `counts` counts of clock/`prescaler` to a period."""

    prescaler: int
    counts: int
    frequency_hz: float


class TimerUse(NamedTuple):
    """The timer of each user, by its number."""

    tick: int
    one_wire: Mapping[str, int]
    """By sensor."""
    pwm: Mapping[str, int]
    """By output."""


class NoTimer(Exception):
    """No timer is left for somebody who needs one."""

    def __init__(self, user: str | None) -> None:
        super().__init__(user)
        self.user = user
        """The sensor that goes without; None for the tick."""


def tick_interval(clock_hz: int, timer: Timer) -> Interval | None:
    """Divide the clock exactly into ticks: fewest interrupts first, then the finest count."""
    cycles, rest = divmod(clock_hz, round(1 / TICK_S))
    for divider in range(1, MOST_DIVIDER + 1):
        for prescaler in timer.prescalers:
            counts, left = divmod(cycles, divider * prescaler)
            if rest == 0 and left == 0 and 1 < counts <= 1 << timer.bits:
                return Interval(prescaler, counts, divider)
    return None


def allocate(controller: Controller) -> TimerUse:
    """Share the board's timers out; raises NoTimer when they do not suffice."""
    board = controller.board
    pwm = dict(_pwm_timers(controller, board))
    free = [number for number in board.timers if number not in pwm.values()]
    tick = _best_for_tick(board, free)
    if tick is None:
        raise NoTimer(None)
    free.remove(tick)
    # Timer 2 before timer 0, which other programs of the board expect to be the clock.
    free.sort(key=lambda number: (board.timers[number].bits, -number))
    one_wire = {}
    for name, sensor in controller.sensors.items():
        if isinstance(sensor, Ds18b20):
            if not free:
                raise NoTimer(name)
            one_wire[name] = free.pop(0)
    return TimerUse(tick, one_wire, pwm)


def _pwm_timers(controller: Controller, board: Board) -> Iterator[tuple[str, int]]:
    for name, output in controller.outputs.items():
        if isinstance(output, PwmOutput):
            pin = board.pins.get(output.pin)
            if pin is not None and pin.pwm is not None:
                yield name, pin.pwm[0]


def _best_for_tick(board: Board, free: list[int]) -> int | None:
    """Choose the timer with the fewest interrupts; of equals not timer 0, then the lowest."""
    rated = []
    for number in free:
        interval = tick_interval(board.clock_hz, board.timers[number])
        if interval is not None:
            rated.append((interval.divider, number == 0, number))
    return min(rated)[2] if rated else None


def pwm_settings(clock_hz: int, timer: Timer) -> Iterator[PwmSetting]:
    """List what an 8-bit timer can make: 256 counts of each prescaled clock, fastest first."""
    for prescaler in timer.prescalers:
        counts = 1 << timer.bits
        yield PwmSetting(prescaler, counts, clock_hz / (prescaler * counts))


def pwm_setting(board: Board, output: PwmOutput) -> PwmSetting:
    """Find the setting nearest to the output's frequency, on the timer of its pin.

    An 8-bit timer counts to 256 (fast PWM, mode 3); a 16-bit one to any number (mode 14), here
    with the smallest prescaler that holds the period, for the finest steps.
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
    """Tell whether a setting is as near to the frequency as a resonator is to its own."""
    return _distance(setting.frequency_hz, wanted_hz) <= 1 + FREQUENCY_TOLERANCE
