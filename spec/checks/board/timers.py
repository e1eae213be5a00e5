"""Timers: there must be enough, and they must be able to make the frequencies."""

from heatwright.spec.board.timers import NoTimer, allocate, ticks_at_all
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.controller import Controller
from heatwright.spec.quantity import hertz


def clock_ticks(controller: Controller) -> Findings:
    """Find clocks that are too fast for the chip, or that no timer divides into ticks of 10 ms."""
    board = controller.board
    path = ("controller", "clock")
    if board.clock_hz > board.fastest_hz:
        yield Finding(
            path,
            f"{hertz(board.clock_hz)} is too fast for the {board.mcu}",
            f"Use at most {hertz(board.fastest_hz)}",
        )
    elif not ticks_at_all(board):
        yield Finding(
            path,
            f"no timer divides {hertz(board.clock_hz)} into ticks of 10 ms",
            "Use a crystal of a whole number of MHz",
        )


def timers_suffice(controller: Controller) -> Findings:
    """Check that everything that needs a timer gets one that can do it."""
    try:
        allocate(controller)
    except NoTimer as error:
        for problem in error.problems:
            yield Finding(*problem)
