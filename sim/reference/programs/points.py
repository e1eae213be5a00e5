"""Segments as a touch display sends them (docs/nextion.md, "Segments")."""

from heatwright.sim.reference.programs.copies import FAST, HOLD, OVER, RATE, UNTIL, Copy, Part
from heatwright.spec import Controller

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
        """Take the limits of the spec.

        Raises ValueError: the specification has no programs.
        """
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
