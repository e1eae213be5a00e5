"""The operator of the timing: presses keys at the worst times, and knows the results."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from heatwright.sim.timing.stage import resting_c
from heatwright.spec import Controller, LcdKeypad

GOLDEN = 0.6180339887498949
"""The fractional parts of its multiples are evenly spread, however many multiples are used."""
HELD_S = 0.06
"""How long a key is held: longer than the debouncing, shorter than by a person."""
SETTLED_S = 0.3
"""After this time the display shows a key's change, or it never does."""
DIGITS = 6
"""Decimals to round to: the binary error of summed tenths is smaller."""
BACK_S = 0.35
"""Time after which the opposite key undoes a key, if its change must not last."""
FIRST_S = 5.0
"""When the first key is pressed: after the start-up."""
BEFORE_S, AFTER_S = 0.045, 0.010
"""A key that is aimed at an action of the program comes this long before or after it, s."""


@dataclass(frozen=True)
class Press:
    """A key, the time it is pressed (s), and the setpoint from then on (°C)."""

    time_s: float
    key: str
    setpoint_c: float


def presses(controller: Controller, keypad: LcdKeypad, times_s: Sequence[float]) -> list[Press]:
    """Assign a key to each time, so that the setpoint moves up and down below the resting point.

    There the simulated machine, which cannot heat, need not heat. A change to above it is undone as
    soon as it has been shown; the times until then are left out. No key goes beyond the range, and
    each one changes the setpoint.
    """
    loop = controller.loops[keypad.loop]
    low_c, high_c = loop.setpoint.minimum_c, loop.setpoint.maximum_c
    resting, setpoint_c = resting_c(controller, keypad.loop), loop.setpoint.initial_c
    found: list[Press] = []
    for time_s in times_s:
        if found and time_s <= found[-1].time_s + SETTLED_S:
            continue
        up = setpoint_c <= low_c or setpoint_c + keypad.step_k <= min(resting, high_c)
        moved_c = round(setpoint_c + (keypad.step_k if up else -keypad.step_k), DIGITS)
        if up and moved_c > resting:
            found.append(Press(time_s, "up", min(moved_c, high_c)))
            found.append(Press(time_s + BACK_S, "down", low_c))
            setpoint_c = low_c
            continue
        setpoint_c = min(max(moved_c, low_c), high_c)
        found.append(Press(time_s, "up" if up else "down", setpoint_c))
    return found


def aimed(until_s: float, steps_s: Sequence[float], refreshes_s: Sequence[float]) -> list[float]:
    """Return times for keys, s: one a second, at all phases of the program's actions.

    Keys are aimed at each refresh of the display and, every other second, at a control step. The
    phases of the other seconds, and all phases of the tick, are spread evenly.
    """
    found: list[float] = []
    for number, second in enumerate(_seconds(until_s)):
        phase = (number * GOLDEN) % 1
        about_s = _within(refreshes_s, second)
        if about_s is None and number % 2:
            about_s = _within(steps_s, second)
        if about_s is None:
            time_s = second + phase
        else:
            time_s = about_s - BEFORE_S + phase * (BEFORE_S + AFTER_S)
        if not found or time_s > found[-1] + SETTLED_S:
            found.append(time_s)
    return found


def _seconds(until_s: float) -> Iterator[float]:
    second = FIRST_S
    while second + 1 + 2 * SETTLED_S < until_s:
        yield second
        second += 1.0


def _within(times_s: Sequence[float], second: float) -> float | None:
    return next((time_s for time_s in times_s if second <= time_s < second + 1), None)
