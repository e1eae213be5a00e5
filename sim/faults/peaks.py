"""How hot the machine became, and how soon its heaters would have had to go off."""

from __future__ import annotations

from collections.abc import Mapping

from heatwright.sim.machine import BITS, FEED, WATCHED, Array, Machine
from heatwright.sim.plants.thermal_network import Plant

SPREADING_S = 600.0
"""How long heat that is under way is followed."""


class Peaks:
    """The highest temperature of every node since a moment, and what was given meanwhile."""

    def __init__(self, machine: Machine, sensor: str) -> None:
        """Begin now; sensor -- whose highest temperature is of interest, too."""
        self._machine = machine
        self._from_c = machine.plant.vector.copy()
        self._first = machine.count
        self._last: int | None = None
        machine.watch(sensor)

    @property
    def ended(self) -> bool:
        """Whether nobody looks any longer."""
        return self._last is not None

    def end(self) -> None:
        """Look no longer: what comes now is another story."""
        if not self.ended:
            self._last = self._machine.count
            self._machine.look(watches=False)

    @property
    def spreads(self) -> bool:
        """Whether no heat is given any more, and still something becomes hotter."""
        return self._machine.spreads

    @property
    def highest_c(self) -> Mapping[str, float]:
        """By node, °C."""
        found = self._machine.highest_c.tolist()
        return dict(zip(self._machine.plant.nodes, found, strict=True))

    def latest_off_s(self, node: str, bears_c: float) -> float:
        """Return until when the heaters may have been on for a node not to become too hot, s.

        Found by halving, with what was given up to then; 0 if it was too hot from the beginning.
        """
        machine = self._machine
        rows = machine.rows[self._first : self._last]
        rows = rows[rows[:, BITS].astype(int) & WATCHED > 0]
        plant = machine.plant.at(self._from_c)
        place = plant.nodes.index(node)
        low, high = 0, len(rows)
        while high - low > 1:
            middle, borne = (low + high) // 2, plant.vector.copy()
            peak_c = self._heated(plant, place, rows[low:middle])
            heated = plant.vector.copy()
            if max(peak_c, self._spread(plant, place)) > bears_c:
                high, plant.vector[:] = middle, borne
            else:
                low, plant.vector[:] = middle, heated
        return low * machine.step_s

    def _heated(self, plant: Plant, place: int, rows: Array) -> float:
        """Give a plant what these rows were given; return the highest temperature of a node."""
        peak_c = float(plant.temperatures_c[place])
        for shares, feed_mm_per_s in zip(self._machine.given(rows), rows[:, FEED], strict=True):
            plant.step(self._named(shares), float(feed_mm_per_s))
            peak_c = max(peak_c, float(plant.temperatures_c[place]))
        return peak_c

    def _spread(self, plant: Plant, place: int) -> float:
        """Give no heat from now on; return the temperature that a node comes to."""
        first = self._machine.rows[self._first : self._first + 1]
        given = self._named(self._machine.given(first)[0]) | dict.fromkeys(plant.heaters, 0.0)
        peak_c = float(plant.temperatures_c[place])
        for _ in range(round(SPREADING_S / self._machine.step_s)):
            plant.step(given, float(first[0, FEED]))
            now_c = float(plant.temperatures_c[place])
            if now_c < peak_c:
                break
            peak_c = now_c
        return peak_c

    def _named(self, shares: Array) -> dict[str, float]:
        return dict(zip(self._machine.loads, shares.tolist(), strict=True))
