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
    return counting_to_compare(board, number, interval.prescaler, f"OCR{number}A = {top};")


def counting_to_compare(board: Board, number: int, prescaler: int, set_top: str) -> list[str]:
    """Lines that start timer `number` in CTC mode; `set_top` is the one that sets its compare."""
    timer = board.timers[number]
    clock = prescaler_bits(number, timer, prescaler)
    if timer.bits == 16:
        modes = [f"TCCR{number}A = 0;"]
        start = f"TCCR{number}B = (1u << WGM{number}2) | {clock};"
    else:
        modes = [f"TCCR{number}A = (1u << WGM{number}1);"]
        start = f"TCCR{number}B = {clock};"
    return [
        *modes,
        set_top,
        f"TCNT{number} = 0;",
        f"TIFR{number} = (1u << OCF{number}A); /* a match from before does not count */",
        f"TIMSK{number} = (1u << OCIE{number}A);",
        start,
    ]


def halted(number: int) -> list[str]:
    """Lines that stop timer `number` and its interrupts."""
    return [f"TCCR{number}B = 0;", f"TIMSK{number} = 0;"]


def free_running(board: Board, number: int, prescaler: int) -> list[str]:
    """Lines that let timer `number` count round and round."""
    clock = prescaler_bits(number, board.timers[number], prescaler)
    return [f"TCCR{number}A = 0;", f"TCCR{number}B = {clock};"]


def fast_pwm(board: Board, number: int, prescaler: int, top: str) -> list[str]:
    """Lines that start timer `number` in fast PWM: to 255, or with 16 bits to `top`."""
    timer = board.timers[number]
    clock = prescaler_bits(number, timer, prescaler)
    if timer.bits == 16:
        return [
            f"ICR{number} = {top};",
            f"TCCR{number}A = (1u << WGM{number}1);",
            f"TCCR{number}B = (1u << WGM{number}3) | (1u << WGM{number}2) | {clock};",
        ]
    return [
        f"TCCR{number}A = (1u << WGM{number}1) | (1u << WGM{number}0);",
        f"TCCR{number}B = {clock};",
    ]


def vector(number: int, channel: str = "A") -> str:
    """Interrupt vector of a compare match of the timer."""
    return f"TIMER{number}_COMP{channel}_vect"
