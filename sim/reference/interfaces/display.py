"""The effect of a touch display's commands, and segments, on the reference device.

See docs/nextion.md, "Segments".
"""

import re
from collections.abc import Callable
from contextlib import suppress

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
        3: operator.set,
        4: operator.set_manual,
        5: lambda kp: operator.set_gains(kp, None, None),
        6: lambda ki: operator.set_gains(None, ki, None),
        19: lambda kd: operator.set_gains(None, None, kd),
        20: operator.set_critical,
    }


def _switch(operator: SwitchedOperator, *, on: bool) -> None:
    """Switch off, or on under automatic control."""
    if not on:
        operator.disable()
    elif operator.enable():
        operator.steer_by_hand(on=False)


def _orders(operator: ProgrammedOperator) -> Does:
    """Return the commands to a program."""
    return {
        8: lambda number: operator.order("start", int(number)),
        9: lambda runs: operator.order("resume" if runs else "pause"),
        10: lambda segment: operator.order("jump", int(segment) + 1),
        17: lambda _: operator.disable(),
        18: lambda _: operator.order("skip"),
    }


TIMED, AT_A_RATE, AT_ONCE, FOR_OPERATOR, HELD = range(5)
"""Kinds of segments, as they are sent."""
SECONDS = MINUTES = 60
LONGEST_S, FASTEST = 2_678_400, 65_535


def _minutes(text: str) -> float:
    """Parse minutes, or hours and minutes: 90, 1h30, 1h. Raises ValueError."""
    hours, h, minutes = text.partition("h")
    if not h:
        return float(text)
    rest = float(minutes or 0)
    if not float(hours).is_integer() or float(hours) < 0 or not 0 <= rest < MINUTES:
        raise ValueError(f"{text}: whole hours, and less than 60 minutes")
    return MINUTES * float(hours) + rest


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
        for point in text.removesuffix(":").split(":"):
            fields = point.split(",")
            if len(fields) not in (3, 4):
                raise ValueError(f"{point}: a segment has three numbers, or four")
            number = float(fields[0])
            is_rate = fields[3:] == [str(AT_A_RATE)]
            amount = float(fields[1]) if is_rate else _minutes(fields[1])
            rest = [amount, *map(float, fields[2:])]
            place = int(number)
            if place != number or not 1 <= place <= min(len(parts) + 1, self._points):
                raise ValueError(f"{point}: there is no place {number:g}")
            if rest == [0, 0]:
                del parts[place - 1 :]
            else:
                parts[place - 1 : place] = [self._part(parts[: place - 1], *rest)]
        return tuple(parts)

    def _part(self, before: list[Part], amount: float, celsius: float, kind: float = TIMED) -> Part:
        to_dc = round(10 * celsius)
        targets = [part.to_dc for part in before if part.target_c is not None]
        stays = kind == TIMED and targets and targets[-1] == to_dc
        if kind == HELD or stays:
            return self._sound(Part(HOLD, 0, round(SECONDS * amount)), LONGEST_S)
        if kind == FOR_OPERATOR:
            return Part(UNTIL)
        if not self._range_dc[0] <= to_dc <= self._range_dc[1]:
            raise ValueError(f"{celsius:g} °C is no setpoint")
        if kind == AT_ONCE:
            return Part(FAST, to_dc)
        if kind == AT_A_RATE:
            return self._sound(Part(RATE, to_dc, round(10 * amount)), FASTEST)
        if kind == TIMED:
            return self._sound(Part(OVER, to_dc, round(SECONDS * amount)), LONGEST_S)
        raise ValueError(f"there is no kind {kind:g}")

    @staticmethod
    def _sound(part: Part, most: int) -> Part:
        if not 1 <= part.amount <= most:
            raise ValueError(f"{part.amount} is not within 1 to {most}")
        return part
