"""Timers: enough of them, and frequencies they can make."""

from __future__ import annotations

from heatwright.spec.boards import Board, Timer
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.controller import Controller
from heatwright.spec.outputs import SLOWEST_PWM_HZ, PwmOutput
from heatwright.spec.quantity import hertz
from heatwright.spec.suggest import listed
from heatwright.spec.timers import (
    FEWEST_COUNTS,
    NoTimer,
    allocate,
    keeps_frequency,
    pwm_setting,
    pwm_settings,
    tick_interval,
)


def clock_ticks(controller: Controller) -> Findings:
    """Find clocks the chip does not bear or that do not divide into ticks of 10 ms."""
    board = controller.board
    path = ("controller", "clock")
    if board.clock_hz > board.fastest_hz:
        yield Finding(
            path,
            f"{hertz(board.clock_hz)} is too fast for the {board.mcu}",
            f"Use at most {hertz(board.fastest_hz)}",
        )
    elif not _ticks_at_all(board):
        yield Finding(
            path,
            f"no timer divides {hertz(board.clock_hz)} into ticks of 10 ms",
            "Use a crystal of a whole number of MHz",
        )


def _ticks_at_all(board: Board) -> bool:
    return any(tick_interval(board.clock_hz, timer) for timer in board.timers.values())


def enough_timers(controller: Controller) -> Findings:
    """Find out whether the tick and each 1-Wire line get a timer beside the PWM outputs."""
    board = controller.board
    if not _ticks_at_all(board):
        return
    try:
        allocate(controller)
    except NoTimer as error:
        path = ("controller", "board") if error.user is None else ("sensors", error.user)
        user = "the tick of 10 ms" if error.user is None else "this 1-Wire line"
        yield Finding(
            path,
            f"no timer of {board.name} is left for {user}: it has {len(board.timers)}, and the "
            "tick, each DS18B20 and each timer with PWM outputs take one",
            "Use time_proportional in place of pwm, or a board with more timers",
            (("controller",), ("outputs",), ("sensors",)),
        )


def pwm_frequencies(controller: Controller) -> Findings:
    """Find frequencies the pin's timer cannot make, or only with too few steps."""
    for name, output, timer in _pwm_outputs(controller):
        board = controller.board
        path = ("outputs", name, "frequency")
        setting = pwm_setting(board, output)
        if not keeps_frequency(setting, output.frequency_hz):
            yield Finding(
                path,
                f"the timer of {output.pin} cannot make {hertz(output.frequency_hz)}"
                f"{' in 100 steps' if timer.bits == 16 else ''}",
                _nearest(board, timer, output.frequency_hz),
                (("controller",), ("outputs", name, "pin")),
            )


def _nearest(board: Board, timer: Timer, wanted_hz: float) -> str:
    if timer.bits == 16:
        slowest = board.clock_hz / (timer.prescalers[-1] << 16)
        fastest = board.clock_hz / FEWEST_COUNTS
        return f"Use {hertz(max(slowest, SLOWEST_PWM_HZ))} to {hertz(fastest)}"
    able = [setting.frequency_hz for setting in pwm_settings(board.clock_hz, timer)]
    below = [each_hz for each_hz in able if each_hz < wanted_hz]
    above = [each_hz for each_hz in able if each_hz > wanted_hz]
    nearest = ([max(below)] if below else []) + ([min(above)] if above else [])
    return f"Use {listed([hertz(each_hz) for each_hz in nearest])}"


def pwm_neighbours(controller: Controller) -> Findings:
    """Find outputs on one timer that want different frequencies."""
    first: dict[int, tuple[str, float]] = {}
    for name, output, _ in _pwm_outputs(controller):
        pin = controller.board.pins[output.pin]
        if pin.pwm is None:
            continue
        other, frequency_hz = first.setdefault(pin.pwm[0], (name, output.frequency_hz))
        if frequency_hz != output.frequency_hz:
            yield Finding(
                ("outputs", name, "frequency"),
                f"{output.pin} shares timer {pin.pwm[0]} with outputs.{other}, which is at "
                f"{hertz(frequency_hz)}",
                "Give both the same frequency, or use a pin of another timer",
                (("controller",), ("outputs", other), ("outputs", name, "pin")),
            )


def _pwm_outputs(controller: Controller) -> list[tuple[str, PwmOutput, Timer]]:
    board = controller.board
    found = []
    for name, output in controller.outputs.items():
        pin = board.pins.get(output.pin)
        if isinstance(output, PwmOutput) and pin is not None and pin.pwm is not None:
            found.append((name, output, board.timers[pin.pwm[0]]))
    return found
