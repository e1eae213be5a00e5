"""Assigns timers to PWM outputs, the tick, 1-Wire lines, steppers and the end of Modbus frames.

A PWM output uses its pin's timer if that can make it. The others are made by compare interrupts of
a free-running 16-bit timer, one output for each of its channels. Then the tick gets a timer, if
possible one with 16 bits, which counts 10 ms in one interrupt where an 8-bit one needs several.
Then each 1-Wire line gets one, if possible with 8 bits, because its slots are short; then each
stepper, if possible with 16 bits; at last a Modbus line.
"""

from collections.abc import Mapping
from typing import NamedTuple

from heatwright.spec.board.pwm_timers import PwmChannel, PwmTimers, TimerProblem, share_pwm
from heatwright.spec.boards import Board, Timer
from heatwright.spec.commands import placed
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import ModbusRtu
from heatwright.spec.problems import Path
from heatwright.spec.proofs import proofs
from heatwright.spec.quantity import number

TICK_S = 0.01
"""The firmware's tick; every period and time-out is a whole number of ticks."""

PULSE_LOOKS = 10
"""Minimum number of samples of a tachometer's pin in one tick: one in every second interrupt of the
timer, but none in the tick's interrupt, which is long."""

MOST_DIVIDER = 255
"""Maximum number of interrupts of the timer in one tick: they are counted in a byte."""

FASTEST_STEPS_HZ = 10_000
"""Maximum steps of a stepper per second: their interrupts, 10 µs each, take 10 % of the time."""

_ALL: tuple[Path, ...] = (("controller",), ("outputs",), ("sensors",))
_OR_NO_PWM = ", or time_proportional in place of pwm"


class Interval(NamedTuple):
    """A compare match every `counts` counts of clock/`prescaler`, `divider` matches to a tick."""

    prescaler: int
    counts: int
    divider: int


class TimerUse(NamedTuple):
    """The number of the timer that each user has."""

    tick: int
    one_wire: Mapping[str, int]
    """Timer by the sensor's name."""
    pwm: Mapping[str, PwmChannel]
    """Channel by the output's name."""
    steppers: Mapping[str, int]
    """Timer by the output's name."""
    silence: int | None = None
    """The Modbus line's timer, if there is one: it detects the end of a frame."""


class NoTimer(Exception):
    """The timers do not suffice, or cannot make a frequency; lists all problems."""

    def __init__(self, problems: tuple[TimerProblem, ...]) -> None:
        super().__init__("; ".join(problem.reason for problem in problems))
        self.problems = problems


def tick_interval(clock_hz: int, timer: Timer, looks: int = 0) -> Interval | None:
    """Divide the clock exactly into ticks: fewest interrupts first, then the finest count.

    looks -- least number of samples of a tachometer in a tick, one in every second interrupt.
    """
    cycles, rest = divmod(clock_hz, round(1 / TICK_S))
    for divider in range(2 * looks or 1, MOST_DIVIDER + 1, 2 if looks else 1):
        for prescaler in timer.prescalers:
            counts, left = divmod(cycles, divider * prescaler)
            if rest == 0 and left == 0 and 1 < counts <= 1 << timer.bits:
                return Interval(prescaler, counts, divider)
    return None


def ticks_at_all(board: Board) -> bool:
    """Return whether any timer of the board divides its clock into ticks."""
    return any(tick_interval(board.clock_hz, timer) for timer in board.timers.values())


def looks(controller: Controller) -> int:
    """Return how often a tick samples tachometers, at least; 0 without any."""
    counted = any(proof.tachometer for proof in proofs(controller).values())
    return PULSE_LOOKS if counted else 0


def looks_in_tick(controller: Controller) -> int:
    """Return how often a tick samples tachometers, in a controller that has some."""
    board = controller.board
    timer = board.timers[allocate(controller).tick]
    interval = tick_interval(board.clock_hz, timer, looks(controller))
    assert interval is not None  # noqa: S101 - `allocate` chose a timer that can
    return interval.divider // 2


def allocate(controller: Controller) -> TimerUse:
    """Decide which of the board's timers each user has.

    Raises NoTimer: they do not suffice, or cannot make a frequency that is asked for.
    """
    board = controller.board
    made = share_pwm(controller)
    free = [number for number in board.timers if number not in made.taken]
    problems = [*made.problems, *_too_fast(controller)]
    short: list[TimerProblem] = []
    tick = _best_for_tick(board, free, looks(controller))
    if tick is not None:
        free.remove(tick)
    elif ticks_at_all(board):
        user = "the tick of 10 ms" + ", which samples a tachometer each 1 ms," * bool(
            looks(controller)
        )
        short.append(_none_left(board, ("controller", "board"), user, made))
    # Timer 2 is used before timer 0, which other programs on the board expect to be their clock.
    free.sort(key=lambda number: (board.timers[number].bits, -number))
    wires = [name for name, each in controller.sensors.items() if each.on_one_wire]
    motors = list(controller.steppers)
    lines = list(placed(controller, ModbusRtu))
    one_wire = {name: free.pop(0) for name in wires[: len(free)]}
    steppers = {name: free.pop() for name in motors[: len(free)]}
    silences = {line: free.pop(0) for line in lines[: len(free)]}
    wanted: list[tuple[Path, str]] = [
        *((("sensors", name), "this 1-Wire line") for name in wires if name not in one_wire),
        *((("outputs", name), "this stepper") for name in motors if name not in steppers),
        *((("interfaces", line), "this Modbus line") for line in lines[len(silences) :]),
    ]
    short += [_none_left(board, path, user, made) for path, user in wanted]
    problems += short[:1]  # with one timer more the others may fit
    if problems or tick is None:
        raise NoTimer(tuple(problems))
    return TimerUse(tick, one_wire, made.channels, steppers, next(iter(silences.values()), None))


def _best_for_tick(board: Board, free: list[int], looks: int) -> int | None:
    """Choose the timer with the fewest interrupts: among equals the lowest, but timer 0 last."""
    rated = []
    for number_ in free:
        interval = tick_interval(board.clock_hz, board.timers[number_], looks)
        if interval is not None:
            rated.append((interval.divider, number_ == 0, number_))
    return min(rated)[2] if rated else None


def _none_left(board: Board, path: Path, user: str, made: PwmTimers) -> TimerProblem:
    by_interrupts = any(channel.by_interrupts for channel in made.channels.values())
    return TimerProblem(
        path,
        f"no timer of {board.name} is left for {user}: it has {len(board.timers)}; the tick, each "
        "DS18B20, each stepper and a Modbus RTU line need one each, and PWM outputs need the timer "
        "of their pins" + (", or by interrupts a 16-bit one" if by_interrupts else ""),
        "Use a board with more timers" + (_OR_NO_PWM if made.channels else ""),
        _ALL,
    )


def _too_fast(controller: Controller) -> list[TimerProblem]:
    return [
        TimerProblem(
            ("outputs", name, "maximum"),
            f"{number(output.maximum_mm_per_s)} mm/s are {steps_hz:.0f} steps a second, and "
            f"interrupts can make at most {FASTEST_STEPS_HZ}",
            f"Use at most {number(FASTEST_STEPS_HZ / output.steps_per_mm)} mm/s, or fewer "
            "microsteps",
            (("outputs", name),),
        )
        for name, output in controller.steppers.items()
        for steps_hz in (output.maximum_mm_per_s * output.steps_per_mm,)
        if steps_hz > FASTEST_STEPS_HZ
    ]
