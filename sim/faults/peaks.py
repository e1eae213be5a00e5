"""How hot the machine became, and how early its heaters should have gone off."""

from collections.abc import Mapping

from heatwright.sim.machine import BITS, FEED, WATCHED, Array, Machine
from heatwright.sim.plants.thermal_network import Plant

SPREADING_S = 600.0
"""Longest time for which the spreading of heat is followed."""


class Peaks:
    """The highest temperature of every node, and the power given, since the recording began."""

    def __init__(self, machine: Machine, sensor: str) -> None:
        """Begin now; sensor -- its highest temperature is recorded, too."""
        self._machine = machine
        self._from_c = machine.plant.vector.copy()
        self._first = machine.count
        self._last: int | None = None
        machine.watch(sensor)

    @property
    def ended(self) -> bool:
        """Whether the recording has ended."""
        return self._last is not None

    def end(self) -> None:
        """End the recording: what happens after it does not count."""
        if not self.ended:
            self._last = self._machine.count
            self._machine.look(watches=False)

    @property
    def spreads(self) -> bool:
        """Whether some node still becomes hotter although no heater gives power."""
        return self._machine.spreads

    @property
    def highest_c(self) -> Mapping[str, float]:
        """Highest temperature by node, °C."""
        found = self._machine.highest_c.tolist()
        return dict(zip(self._machine.plant.nodes, found, strict=True))

    def latest_off_s(self, node: str, bears_c: float) -> float:
        """Return when heaters had to go off at the latest to keep a node within its limit, s.

        The time counts from the start of the recording; it is found by bisection over the recorded
        power. It is 0 if the node was too hot from the beginning.
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
        """Step a plant with these rows' recorded power; return a node's highest temperature."""
        peak_c = float(plant.temperatures_c[place])
        for shares, feed_mm_per_s in zip(self._machine.given(rows), rows[:, FEED], strict=True):
            plant.step(self._named(shares), float(feed_mm_per_s))
            peak_c = max(peak_c, float(plant.temperatures_c[place]))
        return peak_c

    def _spread(self, plant: Plant, place: int) -> float:
        """Let the heat spread without power; return the highest temperature of a node."""
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
