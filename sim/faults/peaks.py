"""How hot the machine became, and how soon its heaters would have had to go off."""

from __future__ import annotations

from collections.abc import Mapping

from heatwright.sim.machine import BITS, FEED, WATCHED, Machine

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
        rows = self._machine.rows[self._first : self._last]
        rows = rows[rows[:, BITS].astype(int) & WATCHED > 0]
        given = [
            dict(zip(self._machine.loads, shares, strict=True))
            for shares in self._machine.given(rows).tolist()
        ]
        fed = list(zip(given, rows[:, FEED].tolist(), strict=True))
        low, high = 0, len(fed)
        while high - low > 1:
            middle = (low + high) // 2
            if self._peak_c(node, fed, middle) > bears_c:
                high = middle
            else:
                low = middle
        return low * self._machine.step_s

    def _peak_c(self, node: str, fed: list[tuple[dict[str, float], float]], rows: int) -> float:
        """Give the same for some rows, and no heat from then on."""
        plant = self._machine.plant.at(self._from_c)
        place, off = plant.nodes.index(node), dict.fromkeys(plant.heaters, 0.0)
        peak_c = float(plant.temperatures_c[place])
        for given, feed_mm_per_s in fed[:rows]:
            plant.step(given, feed_mm_per_s)
            peak_c = max(peak_c, float(plant.temperatures_c[place]))
        given, feed_mm_per_s = fed[0]
        for _ in range(round(SPREADING_S / self._machine.step_s)):
            plant.step({**given, **off}, feed_mm_per_s)
            now_c = float(plant.temperatures_c[place])
            if now_c < peak_c:
                break
            peak_c = now_c
        return peak_c
