"""The operator of the timing: presses keys at the worst of times, and knows what comes of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from heatwright.sim.timing.stage import resting_c
from heatwright.spec import Controller, LcdKeypad

GOLDEN = 0.6180339887498949
"""Its multiples, less their whole part, are spread evenly however many there are."""
HELD_S = 0.06
"""How long a key is held: longer than bouncing is looked at, shorter than a person does."""
SETTLED_S = 0.3
"""After this long the display shows what a key has changed, or never does."""
DIGITS = 6
"""Steps of a tenth, summed in binary, would miss the end of the range by less."""
BACK_S = 0.35
"""So long after a key the opposite one takes back what it did, where that must not last."""
FIRST_S = 5.0
"""When the first key is pressed: start-up is over."""
BEFORE_S, AFTER_S = 0.045, 0.010
"""Keys aimed at something else that the program does come this long before or after it, s."""


@dataclass(frozen=True)
class Press:
    """A key, when it goes down (s), and the setpoint from then on (°C)."""

    time_s: float
    key: str
    setpoint_c: float


def presses(controller: Controller, keypad: LcdKeypad, times_s: Sequence[float]) -> list[Press]:
    """Give the times their keys, so that the setpoint goes up and down below the resting point.

    There the machine need not heat, which it cannot. What leads above it is taken back as soon as
    it has been shown, and the times until that has been are left out. A key leads no further than
    to an end of the range, and each of these changes the setpoint.
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
    """Return times for keys: one a second, at phases of all that the program does, s.

    Each refresh of the display is aimed at, every other second a control step; the phases of the
    other seconds, and all phases of the tick, are spread evenly.
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
