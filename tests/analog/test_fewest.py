"""The broken line of fewest points is just that: held against trying every set of bends."""

import random
from itertools import combinations, pairwise

import numpy as np
import pytest
from scipy.optimize import linprog

from heatwright.spec.fewest import Tube, fewest_points


def feasible(tube: Tube, bends: tuple[int, ...]) -> bool:
    """Whether some line with these bends stays in the tube: a linear programme in their values."""
    rows, bounds = [], []
    for place, (low, high) in enumerate(zip(tube.lows, tube.highs, strict=True)):
        weights = np.array([np.interp(place, bends, unit) for unit in np.eye(len(bends))])
        rows += [weights, -weights]
        bounds += [high, -low]
    found = linprog(np.zeros(len(bends)), rows, bounds, bounds=(None, None))
    return bool(found.status == 0)


def by_trying(tube: Tube) -> int:
    """Fewest points, by trying all sets of bends, smallest sets first."""
    last = len(tube.lows) - 1
    for inner in range(last):
        for bends in combinations(range(1, last), inner):
            if feasible(tube, (0, *bends, last)):
                return inner + 2
    raise AssertionError("not even a bend at every place will do")


def random_tube(seed: int) -> Tube:
    picked = random.Random(seed)  # noqa: S311 - no secret
    size = picked.randint(2, 9)
    shape = picked.choice(("walk", "sine", "decay"))
    values, value = [], 0.0
    for place in range(size):
        value += picked.gauss(0, 1)
        smooth = np.sin(place * 0.9) * 4 if shape == "sine" else 9 * np.exp(-place / 3)
        values.append(value if shape == "walk" else smooth)
    widths = [picked.uniform(0.02, 1.0) for _ in values]
    return Tube(
        [value - width for value, width in zip(values, widths, strict=True)],
        [value + picked.uniform(0.02, 1.0) for value in values],
    )


@pytest.mark.parametrize("seed", range(60))
def test_no_set_of_fewer_bends_will_do(seed: int) -> None:
    tube = random_tube(seed)
    points = fewest_points(tube)
    assert len(points) == by_trying(tube)


@pytest.mark.parametrize("seed", range(200))
def test_the_line_stays_in_the_tube(seed: int) -> None:
    tube = random_tube(seed)
    places, values = zip(*fewest_points(tube), strict=True)
    assert places[0] == 0
    assert places[-1] == len(tube.lows) - 1
    assert all(left < right for left, right in pairwise(places))
    line = np.interp(range(len(tube.lows)), places, values)
    scale = max(abs(value) for value in (*tube.lows, *tube.highs))
    assert np.all(line >= np.array(tube.lows) - 8 * np.finfo(float).eps * scale)
    assert np.all(line <= np.array(tube.highs) + 8 * np.finfo(float).eps * scale)


def test_a_tube_of_one_place_has_one_point() -> None:
    assert fewest_points(Tube([1.0], [2.0])) == [(0, 1.5)]


def test_a_closed_tube_is_refused() -> None:
    with pytest.raises(ValueError, match="crossed"):
        fewest_points(Tube([0.0, 2.0], [1.0, 1.0]))
