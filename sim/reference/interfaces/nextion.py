"""The effect of a touch display's commands, and segments, on the reference device.

See docs/nextion.md, "Segments".
"""

import re
from collections.abc import Callable
from contextlib import suppress
from fractions import Fraction
from math import floor

from heatwright.sim.reference.interfaces.operator import Operator
from heatwright.sim.reference.interfaces.switched import SwitchedOperator
from heatwright.sim.reference.programs.copies import FAST, HOLD, OVER, RATE, UNTIL, Copy, Part
from heatwright.sim.reference.programs.orders import ProgrammedOperator
from heatwright.spec import Controller

_ORDER = re.compile(r"#(\d{1,2}) ?([^#;]*);")
POINTS = 7

Does = dict[int, Callable[[float], object]]


class Display:
    """A touch display that gets no answers.

    Only commands that change something have an effect; requests for a page, a name or a list have
    none. A command that the firmware would refuse changes nothing.
    """

    def __init__(
        self, controller: Controller, operator: Operator, acknowledge: Callable[[], None]
    ) -> None:
        """Serve an operator's loop; `acknowledge` acknowledges a fault of any loop.

        Raises TypeError: the loop has no switch.
        """
        if not isinstance(operator, SwitchedOperator):
            raise TypeError("A display needs a loop that is switched")
        self._does: Does = {**_steering(operator), 16: lambda _: acknowledge()}
        self._programs: ProgrammedOperator | None = None
        if isinstance(operator, ProgrammedOperator):
            self._programs = operator
            self._editor = Editor(controller)
            self._shown = 1
            self._does |= {**_orders(operator), 13: self._show}

    def send(self, text: str) -> None:
        """Execute the commands of a text. Raises ValueError: there is no command in it."""
        found = _ORDER.findall(text)
        if not found:
            raise ValueError(f"{text!r} is no command of a display: write one such as #8 1;")
        for order, data in found:
            self._do(int(order), data)

    def _do(self, order: int, data: str) -> None:
        does = self._does.get(order)
        with suppress(ValueError):
            if order == POINTS and self._programs is not None:
                shown = self._programs.copies.get(self._shown, ())
                self._programs.copies[self._shown] = self._editor.edited(shown, data)
            elif does is not None:
                does(float(data or 0))

    def _show(self, number: float) -> None:
        self._shown = int(number)


def _steering(operator: SwitchedOperator) -> Does:
    """Return the commands that need no programs."""
    return {
        2: lambda on: _switch(operator, on=bool(on)),
        17: lambda _: operator.touch_off(),
        3: operator.set,
        4: operator.set_manual,
        5: lambda kp: operator.set_gains(kp, None, None),
        6: lambda ki: operator.set_gains(None, ki, None),
        19: lambda kd: operator.set_gains(None, None, kd),
        20: operator.set_critical,
    }


def _switch(operator: SwitchedOperator, *, on: bool) -> None:
    """Switch off, or on under automatic control, as a person does."""
    if not on:
        operator.touch_off()
    elif operator.touch_on():
        operator.steer_by_hand(on=False)


def _orders(operator: ProgrammedOperator) -> Does:
    """Return the commands to a program."""
    return {
        8: lambda number: operator.order("start", int(number)),
        9: lambda runs: operator.order("resume" if runs else "pause"),
        10: lambda segment: operator.order("jump", int(segment) + 1),
        18: lambda _: operator.order("skip"),
    }


TIMED, AT_A_RATE, HELD = 0, 1, 4
"""Kinds of segments, as they are sent; 2 is as fast as possible, 3 waits for the operator."""
LIMITS = {OVER: 2_678_400, HOLD: 2_678_400, RATE: 65_535}
"""Longest times, s, and fastest rate, 0.1 K/h."""
MOST_HUNDREDTHS, MOST_TENTHS = 99_999_999, 32_767
"""Largest numbers that may be sent: an amount, and a temperature."""
HOUR = 6_000
"""In hundredths of a minute."""
_NUMBER = r"-?(?:\d+\.?\d*|\.\d+)"
_SEGMENT = re.compile(rf"(\d+),(?!,)(?:({_NUMBER})h)?({_NUMBER})?,({_NUMBER})(?:,(\d+))?", re.ASCII)


def _steps(text: str, decimals: int) -> int:
    """Parse a number in units of its last decimal; halves are rounded away from zero."""
    size: int = floor(Fraction(text.removeprefix("-")) * 10**decimals + Fraction(1, 2))
    return -size if text.startswith("-") else size


def _hundredths(hours: str | None, amount: str | None) -> int:
    """Parse minutes or a rate, as 90, or hours and minutes, as 1h30 or 1h. Raises ValueError."""
    whole, rest = _steps(hours or "0", 2), _steps(amount or "0", 2)
    if hours and (whole < 0 or whole % 100 or not 0 <= rest < HOUR):
        raise ValueError(f"{hours}h{amount or ''}: whole hours, and less than 60 minutes")
    return whole // 100 * HOUR + rest


class Editor:
    """Changes segments of programs, within the spec's limits."""

    def __init__(self, controller: Controller) -> None:
        """Take the limits of the spec. Raises ValueError: the specification has no programs."""
        if controller.programs is None:
            raise ValueError("The specification has no programs")
        setpoint = controller.loops[controller.programs.loop].setpoint
        self._points = controller.programs.points
        self._range_dc = round(10 * setpoint.minimum_c), round(10 * setpoint.maximum_c)

    def edited(self, copy: Copy, text: str) -> Copy:
        """Return a program with segments changed.

        Raises ValueError: some of it is invalid; the program is then unchanged.
        """
        parts = list(copy)
        if not text.endswith(":"):
            raise ValueError(f"{text!r} does not end with a colon")
        for point in text[:-1].split(":"):
            found = _SEGMENT.fullmatch(point)
            if found is None:
                raise ValueError(f"{point!r} is no segment")
            place, kind = int(found[1]), int(found[5] or TIMED)
            amount, to_dc = _hundredths(found[2], found[3]), _steps(found[4], 1)
            if kind == AT_A_RATE and found[2]:
                raise ValueError(f"{point}: a rate has no hours")
            if not 0 <= amount <= MOST_HUNDREDTHS or abs(to_dc) > MOST_TENTHS or kind > HELD:
                raise ValueError(f"{point}: a number is out of range")
            ends = kind == amount == to_dc == 0
            if not 1 <= place <= min(len(parts) + 1, self._points + ends):
                raise ValueError(f"{point}: there is no place {place}")
            if ends:
                del parts[place - 1 :]
            else:
                parts[place - 1 : place] = [_part(parts[: place - 1], kind, amount, to_dc)]
        if not all(map(self._is_sound, parts)):
            raise ValueError(f"{text}: a temperature, time or rate is out of range")
        return tuple(parts)

    def _is_sound(self, part: Part) -> bool:
        lowest, highest = self._range_dc
        return (part.target_c is None or lowest <= part.to_dc <= highest) and (
            part.kind not in LIMITS or 1 <= part.amount <= LIMITS[part.kind]
        )


def _part(before: list[Part], kind: int, amount: int, to_dc: int) -> Part:
    """Return the segment after some others; a timed one that keeps their target is a hold."""
    targets = [part.to_dc for part in before if part.target_c is not None]
    if kind == TIMED and targets[-1:] == [to_dc]:
        kind = HELD
    seconds, rate = (6 * amount + 5) // 10, (amount + 5) // 10
    over, at_a_rate = Part(OVER, to_dc, seconds), Part(RATE, to_dc, rate)
    return (over, at_a_rate, Part(FAST, to_dc), Part(UNTIL), Part(HOLD, 0, seconds))[kind]
