"""Timers: prescaler and compare value for an interval, and the C lines that set them."""

import math
from dataclasses import dataclass

from heatwright.spec.board.timers import MOST_DIVIDER, Interval
from heatwright.spec.boards import Board, Timer


@dataclass(frozen=True, slots=True)
class TimerRegisters:
    """Names of one timer's registers, bits and vectors."""

    number: int
    timer: Timer
    shared: bool
    """TIMSK and TIFR belong to all timers: a line that changes them needs interrupts off."""

    @property
    def first(self) -> str:
        """The first compare channel: its match resets the counter in CTC mode."""
        return self.timer.channels[0]

    @property
    def alone(self) -> bool:
        """True for a timer with one control register, TCCR0, instead of TCCR0A and TCCR0B."""
        return self.shared and self.timer.bits == 8

    @property
    def control_a(self) -> str:
        """The register that sets the modes of the timer's output pins."""
        return f"TCCR{self.number}" if self.alone else f"TCCR{self.number}A"

    @property
    def control_b(self) -> str:
        """The register that selects the clock."""
        return f"TCCR{self.number}" if self.alone else f"TCCR{self.number}B"

    @property
    def counter(self) -> str:
        """The counter."""
        return f"TCNT{self.number}"

    @property
    def compare_type(self) -> str:
        """Type in C of a count, and of a compare value."""
        return "uint16_t" if self.timer.bits == 16 else "uint8_t"

    @property
    def _mask(self) -> str:
        return "TIMSK" if self.shared else f"TIMSK{self.number}"

    def compare(self, channel: str | None = None) -> str:
        """The compare register of a channel; the first if none is named."""
        return f"OCR{self.number}{self._channel(channel)}"

    def vector(self, channel: str | None = None) -> str:
        """Interrupt vector of a channel's match."""
        return f"TIMER{self.number}_COMP{self._channel(channel)}_vect"

    def _enable(self, channel: str | None) -> str:
        return f"(1u << OCIE{self.number}{self._channel(channel)})"

    def _channel(self, channel: str | None) -> str:
        return self.first if channel is None else channel

    def interrupt_on(self, channel: str | None = None) -> str:
        """Enable the interrupt of a channel's match; others of the timer are unchanged."""
        return f"{self._mask} |= {self._enable(channel)};"

    def interrupt_off(self, channel: str | None = None) -> str:
        """Disable the interrupt of a channel's match."""
        return f"{self._mask} &= (uint8_t)~{self._enable(channel)};"

    def interrupt_is_on(self, channel: str | None = None) -> str:
        """C condition: the interrupt of a channel's match is enabled."""
        return f"({self._mask} & {self._enable(channel)})"

    def only_interrupt(self) -> str:
        """Enable the first channel's interrupt, and no other of the timer."""
        return self.interrupt_on() if self.shared else f"{self._mask} = {self._enable(None)};"

    def no_interrupt(self) -> str:
        """Disable all interrupts of the timer."""
        return self.interrupt_off() if self.shared else f"{self._mask} = 0;"

    def forget(self) -> str:
        """Clear the flag of the first channel's match."""
        return f"TIFR{'' if self.shared else self.number} = (1u << OCF{self.number}{self.first});"

    def clock(self, prescaler: int) -> str:
        """The clock-select bits by name, such as `(1u << CS11) | (1u << CS10)`."""
        code = self.timer.prescalers.index(prescaler) + 1
        names = [f"(1u << CS{self.number}{bit})" for bit in (2, 1, 0) if code & (1 << bit)]
        return " | ".join(names)


def registers(board: Board, number: int) -> TimerRegisters:
    """Name the registers of a board's timer."""
    return TimerRegisters(number, board.timers[number], board.is_old)


def slot_interval(clock_hz: int, timer: Timer, shortest_us: float) -> Interval:
    """Return the shortest interval of at least `shortest_us`, with the finest prescaler for it."""
    for prescaler in timer.prescalers:
        counts = -(-clock_hz * shortest_us // (prescaler * 1_000_000))
        if counts <= 1 << timer.bits:
            return Interval(prescaler, int(counts), 1)
    raise ValueError(f"a {timer.bits}-bit timer cannot count {shortest_us} us")


def round_interval(clock_hz: int, timer: Timer, shortest_s: float) -> Interval:
    """Return the interval of a free-running timer with the fewest matches, then the finest counts.

    It lasts at least `shortest_s`. Its counts are less than a full turn of the timer: after a full
    turn the counter has its old value.
    """
    for matches in range(1, MOST_DIVIDER + 1):
        for prescaler in timer.prescalers:
            counts = math.ceil(clock_hz * shortest_s / (prescaler * matches))
            if counts < 1 << timer.bits:
                return Interval(prescaler, counts, matches)
    raise ValueError(f"a {timer.bits}-bit timer cannot count {shortest_s} s")


def compare_match(timer: TimerRegisters, interval: Interval, top: str) -> list[str]:
    """Lines that start a timer in CTC mode, with an interrupt at `top`."""
    return counting_to_compare(timer, interval.prescaler, f"{timer.compare()} = {top};")


def counting_to_compare(timer: TimerRegisters, prescaler: int, set_top: str) -> list[str]:
    """Lines that start a timer in CTC mode; `set_top` is the line that sets its compare value."""
    number, clock = timer.number, timer.clock(prescaler)
    modes, start = [], clock
    if timer.timer.bits == 16:
        modes = [f"{timer.control_a} = 0;"]
        start = f"(1u << WGM{number}2) | {clock}"
    elif timer.alone:
        start = f"(1u << WGM{number}1) | {clock}"
    else:
        modes = [f"{timer.control_a} = (1u << WGM{number}1);"]
    return [
        *modes,
        set_top,
        f"{timer.counter} = 0;",
        f"{timer.forget()} /* drop an earlier match */",
        timer.only_interrupt(),
        f"{timer.control_b} = {start};",
    ]


def halted(timer: TimerRegisters) -> list[str]:
    """Lines that stop a timer and its interrupts."""
    return [f"{timer.control_b} = 0;", timer.no_interrupt()]


def free_running(timer: TimerRegisters, prescaler: int) -> list[str]:
    """Lines that let a timer run free."""
    start = f"{timer.control_b} = {timer.clock(prescaler)};"
    return [start] if timer.alone else [f"{timer.control_a} = 0;", start]


def fast_pwm(timer: TimerRegisters, prescaler: int, top: str, connections: str) -> list[str]:
    """Lines that set a timer to fast PWM, up to 255 or (16 bits) up to `top`, also while it runs.

    connections -- the bits that connect the timer to its outputs' pins; they are not changed.
    """
    number, clock = timer.number, timer.clock(prescaler)
    mode = f"(1u << WGM{number}1) | (1u << WGM{number}0)"
    if timer.timer.bits == 16:
        return [
            f"ICR{number} = {top};",
            _beside(timer.control_a, connections, f"(1u << WGM{number}1)"),
            f"{timer.control_b} = (1u << WGM{number}3) | (1u << WGM{number}2) | {clock};",
        ]
    if timer.alone:
        return [_beside(timer.control_a, connections, f"{mode} | {clock}")]
    return [_beside(timer.control_a, connections, mode), f"{timer.control_b} = {clock};"]


def _beside(register: str, kept: str, bits: str) -> str:
    mask = f"({kept})" if " | " in kept else kept
    return f"{register} = (uint8_t)(({register} & {mask}) | {bits});"
