"""How hot the machine became, and how soon its heaters would have had to go off."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy

import numpy as np

from heatwright.sim.plants import Plant

SPREADING_S = 600.0
"""How long heat that is under way is followed."""


class Peaks:
    """The highest temperature of every node since a moment, and what was given meanwhile.

    spreads -- whether no heat is given any more, and still something becomes hotter.
    """

    def __init__(self, plant: Plant, step_s: float) -> None:
        """Begin now."""
        self._from, self._step_s = deepcopy(plant), step_s
        self._highest_c = plant.temperatures_c.copy()
        self._given: list[tuple[Mapping[str, float], float]] = []
        self._ended = False
        self.spreads = False

    def end(self) -> None:
        """Look no longer: what comes now is another story."""
        self._ended = True

    @property
    def highest_c(self) -> dict[str, float]:
        """By node, °C."""
        return dict(zip(self._from.nodes, self._highest_c.tolist(), strict=True))

    def note(self, plant: Plant, given: Mapping[str, float], feed_mm_per_s: float) -> None:
        """Take in what was given in a step, and what it made of the machine."""
        if self._ended:
            return
        self._given.append((given, feed_mm_per_s))
        rises = bool((plant.temperatures_c > self._highest_c).any())
        self.spreads = rises and not any(given[name] for name in plant.heaters)
        np.maximum(self._highest_c, plant.temperatures_c, out=self._highest_c)

    def latest_off_s(self, node: str, bears_c: float) -> float:
        """Return until when the heaters may have been on for a node not to become too hot, s.

        Found by halving, with what was given up to then; 0 if it was too hot from the beginning.
        """
        low, high = 0, len(self._given)
        while high - low > 1:
            middle = (low + high) // 2
            if self._peak_c(node, middle) > bears_c:
                high = middle
            else:
                low = middle
        return low * self._step_s

    def _peak_c(self, node: str, rows: int) -> float:
        """Give the same for some rows, and no heat from then on."""
        plant = deepcopy(self._from)
        place, off = plant.nodes.index(node), dict.fromkeys(plant.heaters, 0.0)
        peak_c = float(plant.temperatures_c[place])
        for given, feed_mm_per_s in self._given[:rows]:
            plant.step(given, feed_mm_per_s)
            peak_c = max(peak_c, float(plant.temperatures_c[place]))
        given, feed_mm_per_s = self._given[0]
        for _ in range(round(SPREADING_S / self._step_s)):
            plant.step({**given, **off}, feed_mm_per_s)
            now_c = float(plant.temperatures_c[place])
            if now_c < peak_c:
                break
            peak_c = now_c
        return peak_c
