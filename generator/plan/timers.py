"""Timers: prescaler and compare value for a duty, and the register lines that set it up."""

from __future__ import annotations

from heatwright.spec.boards import Board, Timer
from heatwright.spec.timers import Interval


def slot_interval(clock_hz: int, timer: Timer, shortest_us: float) -> Interval:
    """The shortest interval of at least `shortest_us`, in the finest counts that hold it."""
    for prescaler in timer.prescalers:
        counts = -(-clock_hz * shortest_us // (prescaler * 1_000_000))
        if counts <= 1 << timer.bits:
            return Interval(prescaler, int(counts), 1)
    message = f"a {timer.bits}-bit timer cannot count {shortest_us} us"
    raise ValueError(message)


def prescaler_bits(number: int, timer: Timer, prescaler: int) -> str:
    """The clock-select bits by name, such as `(1u << CS11) | (1u << CS10)`."""
    code = timer.prescalers.index(prescaler) + 1
    names = [f"(1u << CS{number}{bit})" for bit in (2, 1, 0) if code & (1 << bit)]
    return " | ".join(names)


def compare_match(board: Board, number: int, interval: Interval, top: str) -> list[str]:
    """Lines that start timer `number` in CTC mode, with an interrupt at `top`."""
    timer = board.timers[number]
    clock = prescaler_bits(number, timer, interval.prescaler)
    if timer.bits == 16:
        modes = [f"TCCR{number}A = 0;"]
        start = f"TCCR{number}B = (1u << WGM{number}2) | {clock};"
    else:
        modes = [f"TCCR{number}A = (1u << WGM{number}1);"]
        start = f"TCCR{number}B = {clock};"
    return [
        *modes,
        f"OCR{number}A = {top};",
        f"TCNT{number} = 0;",
        f"TIFR{number} = (1u << OCF{number}A); /* a match from before does not count */",
        f"TIMSK{number} = (1u << OCIE{number}A);",
        start,
    ]


def vector(number: int) -> str:
    """Interrupt vector of the timer's compare match A."""
    return f"TIMER{number}_COMPA_vect"
