"""The broken line with the fewest points within a tube.

At each place 0, 1, 2 … the tube has a lowest and a highest value; the line must pass between them
everywhere, and may bend at any place, at any value. A search in the manner of H. Imai and M. Iri,
"An optimal algorithm for approximating a piecewise linear function", J. Inf. Process. 9 (1986),
but exact for bends at whole places: for each place it keeps all values that a line of fewest pieces
can reach there.
"""

from collections.abc import Iterator, Sequence
from itertools import islice, pairwise
from typing import NamedTuple

FIRST_BENDS = (6, 24, 1 << 16)
"""How many places to try for each bend: first 6, which usually suffice, then 24, then all."""


class Tube(NamedTuple):
    """Lowest and highest value at each place."""

    lows: Sequence[float]
    highs: Sequence[float]


class Window(NamedTuple):
    """Values at a place that straight lines from place `origin` reach."""

    low: float
    high: float
    origin: int


def fewest_points(tube: Tube) -> list[tuple[int, float]]:
    """Return the places and values of a line through the tube, first and last place included.

    Raises ValueError: the tube is closed.
    """
    if any(low > high for low, high in zip(*tube, strict=True)):
        raise ValueError("no line fits between limits that have crossed")
    corridor = _Corridor(tube)
    pieces = corridor.least
    while True:
        for most in FIRST_BENDS:
            layers = [corridor.bends(bend, pieces, most) for bend in range(pieces + 1)]
            reached = _reached(tube, layers)
            if reached[-1][layers[-1][0]]:
                return _path(tube, layers, reached)
        pieces += 1


def _straight(tube: Tube, gate: Window, start: int, step: int) -> Iterator[Window]:
    """Follow all lines from a window, `gate`; yield the values that they reach at each place.

    J. O'Rourke, "An on-line algorithm for fitting straight lines between data ranges", Commun. ACM
    24 (1981): of all lines that have passed so far, only the steepest upwards and downwards matter.
    Each touches a lower and an upper limit, which the hulls of the limits give.
    """
    lows, highs = tube
    below, above = [(0, gate.low)], [(0, gate.high)]
    rise, fall = (0, gate.low, float("inf")), (0, gate.high, float("-inf"))
    for x in range(1, len(lows) if step > 0 else start + 1):
        place = start + step * x
        if not 0 <= place < len(lows):
            return
        low, high = lows[place], highs[place]
        most = rise[1] + (x - rise[0]) * rise[2]
        least = fall[1] + (x - fall[0]) * fall[2]
        if most < low or least > high:
            return
        if most > high:
            rise, most = _tangent(below, x, high, 1), high
        if least < low:
            fall, least = _tangent(above, x, low, -1), low
        yield Window(least, most, start)
        _extend(below, x, low, 1)
        _extend(above, x, high, -1)


def _tangent(
    hull: list[tuple[int, float]], x: int, y: float, sign: int
) -> tuple[int, float, float]:
    """Find the flattest line (times sign) from the hull to a point; delete the hull before it."""
    best, best_slope = 0, (y - hull[0][1]) / (x - hull[0][0])
    for index in range(1, len(hull)):
        slope = (y - hull[index][1]) / (x - hull[index][0])
        if sign * slope > sign * best_slope:
            break
        best, best_slope = index, slope
    del hull[:best]
    return x, y, best_slope


def _extend(hull: list[tuple[int, float]], x: int, y: float, sign: int) -> None:
    """Add a point to a hull that bulges upwards (sign 1) or downwards (−1)."""
    while len(hull) > 1:
        (x0, y0), (x1, y1) = hull[-2:]
        if sign * ((y1 - y0) * (x - x0) - (y - y0) * (x1 - x0)) > 0:
            break
        del hull[-1]
    hull.append((x, y))


class _Corridor:
    """Where the bends of a line with a given number of pieces can be.

    The longest pieces, which need not even meet, bound how far the first pieces can reach, and how
    far before the end the last ones can begin.
    """

    def __init__(self, tube: Tube) -> None:
        self.last = len(tube.lows) - 1
        self._ahead = _longest(tube, 0, 1)
        self._back = _longest(tube, self.last, -1)
        self.least = len(self._back) - 1
        """Minimum number of pieces of any line."""

    def bends(self, bend: int, pieces: int, most: int) -> list[int]:
        """List the places where bend number `bend` can be, or `most` of them, evenly."""
        high = self._ahead[min(bend, len(self._ahead) - 1)]
        low = self._back[min(pieces - bend, len(self._back) - 1)]
        step = max(1, -(-(high - low) // most))
        return [*range(high, low - 1, -step)][::-1]


def _longest(tube: Tube, start: int, step: int) -> list[int]:
    """List the ends of straight pieces that begin where the one before ended, at any value."""
    ends = [start]
    while length := sum(1 for _ in _straight(tube, _whole(tube, ends[-1]), ends[-1], step)):
        ends.append(ends[-1] + step * length)
    return ends


def _whole(tube: Tube, place: int) -> Window:
    return Window(tube.lows[place], tube.highs[place], place)


Layer = dict[int, list[Window]]
"""The values that lines can reach at each place of a bend."""


def _reached(tube: Tube, layers: Sequence[Sequence[int]]) -> list[Layer]:
    """Find the values that lines reach at each bend, if each bend is at a place of its layer."""
    reached: list[Layer] = [{0: [_whole(tube, 0)]}]
    for places in layers[1:]:
        layer: Layer = {place: [] for place in places}
        for start, windows in reached[-1].items():
            for gate in _united(windows):
                lines = _straight(tube, gate, start, 1)
                for place, window in enumerate(islice(lines, places[-1] - start), start + 1):
                    if place in layer:
                        layer[place].append(window)
        reached.append(layer)
    return reached


def _united(windows: Sequence[Window]) -> list[Window]:
    """Unite windows that overlap; their origins are lost."""
    united: list[Window] = []
    for window in sorted(windows):
        if united and window.low <= united[-1].high:
            high = max(united[-1].high, window.high)
            united[-1] = united[-1]._replace(high=high)
        else:
            united.append(window)
    return united


def _path(
    tube: Tube, layers: Sequence[Sequence[int]], reached: Sequence[Layer]
) -> list[tuple[int, float]]:
    """Go back from the end, each time through the middle of the possible values."""
    place = layers[-1][0]
    low, high, _ = max(reached[-1][place], key=lambda each: each.high - each.low)
    points = [(place, (low + high) / 2)]
    for before, layer in pairwise(reversed(reached)):
        place, value = points[-1]
        origin = next(each.origin for each in before[place] if each.low <= value <= each.high)
        points.append((origin, _back(tube, points[-1], origin, _united(layer[origin]))))
    return points[::-1]


def _back(tube: Tube, point: tuple[int, float], origin: int, gates: Sequence[Window]) -> float:
    """Choose a value at `origin` from which a straight line comes to a point."""
    place, value = point
    *_, back = islice(_straight(tube, Window(value, value, place), place, -1), place - origin)
    low, high = max(
        ((max(back.low, gate.low), min(back.high, gate.high)) for gate in gates),
        key=lambda gate: gate[1] - gate[0],
    )
    return (low + high) / 2
