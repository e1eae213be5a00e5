"""N thermal networks of one structure, advanced together: one matrix-vector product for each.

The values of a lane (one trial) equal its `thermal_network.Plant`'s bit for bit: it uses that
plant's matrices and random generators (for the noise), and the same routine for the product.
"""

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.arrays.stack import UnlikeError
from heatwright.sim.plants import Plant
from heatwright.sim.plants.radiation import LOG_GRID, ZERO_C_K, Surface, on_grid
from heatwright.sim.plants.sensing import Ammeter, Feeler
from heatwright.sim.plants.thermal_network import Plant as Network

Numbers = NDArray[np.float64]


class Plants:
    """The machines of all lanes."""

    def __init__(self, plants: Sequence[Plant]) -> None:
        """Combine plants that advance in equal steps of time.

        Raises UnlikeError: their nodes, heaters, fans or sensors are not the same.
        """
        self._plants = tuple(cast("Network", each) for each in plants)
        first = self._plants[0]
        if len({_structure(each) for each in self._plants}) > 1:
            raise UnlikeError("plants of several structures")
        self.nodes, self._fans = first.nodes, first.fans
        self._states = first.states
        self._vectors = np.array([each.vector for each in self._plants])
        self._heaters = tuple(name for name, _ in first.heaters_w)
        powers_w = [[power_w for _, power_w in each.heaters_w] for each in self._plants]
        self._powers_w = np.array(powers_w).reshape(len(self._plants), -1)
        self._radiant = self._states + len(self._heaters)
        width = first.vector.shape[0]
        self._matrices = np.zeros((len(self._plants), self._states, width))
        self._surfaces = tuple(
            Surfaces([each.surfaces[place] for each in self._plants])
            for place in range(len(first.surfaces))
        )
        self._keys = np.full((len(self._plants), 1 + len(self._fans) + len(self._surfaces)), np.nan)
        self._known: list[dict[bytes, Numbers]] = [{} for _ in self._plants]
        self._feelers = {
            name: Feelers([each.feelers[name] for each in self._plants]) for name in first.feelers
        }
        self._ammeters = {
            name: Ammeters([each.ammeters[name] for each in self._plants])
            for name in first.ammeters
        }

    @property
    def temperatures_c(self) -> Numbers:
        """Temperatures of the nodes, a row for each lane, °C."""
        return self._vectors[:, : len(self.nodes)]

    def sensed_c(self) -> dict[str, Numbers]:
        """Return the present temperature of every sensor's tip in each lane, °C."""
        return {name: feelers.felt_c for name, feelers in self._feelers.items()}

    def currents_a(self) -> dict[str, Numbers]:
        """Return the present current at every current sensor in each lane, A."""
        return {name: meters.amperes for name, meters in self._ammeters.items()}

    def step(self, active: Mapping[str, Any], feed_mm_per_s: Any = 0.0) -> None:
        """Advance by one step, as `Plant.step`; each number may be an array, one per lane."""
        for meters in self._ammeters.values():
            meters.follow(active[meters.output])
        for place, name in enumerate(self._heaters):
            self._vectors[:, self._states + place] = active[name] * self._powers_w[:, place]
        keys = np.empty_like(self._keys)
        keys[:, 0] = feed_mm_per_s
        for place, name in enumerate(self._fans, 1):
            keys[:, place] = active[name]
        for place, surfaces in enumerate(self._surfaces):
            column = 1 + len(self._fans) + place
            keys[:, column], self._vectors[:, self._radiant + place] = surfaces.now(self._vectors)
        changed = (keys != self._keys).any(axis=1)
        if changed.any():
            self._renew(np.flatnonzero(changed), keys)
        found = np.matmul(self._matrices, self._vectors[:, :, None])
        self._vectors[:, : self._states] = found[:, :, 0]
        for feelers in self._feelers.values():
            feelers.feel(self._vectors)

    def _renew(self, lanes: NDArray[np.int64], keys: Numbers) -> None:
        """Select the matrices for the present fans, feed and surfaces."""
        fans = slice(1, 1 + len(self._fans))
        for lane in lanes.tolist():
            row, known = keys[lane], self._known[lane]
            key = row.tobytes()
            if key not in known:
                feed, *rest = row.tolist()
                split = len(self._fans)
                known[key] = self._plants[lane].matrix(
                    tuple(row[fans].tolist()), feed, tuple(rest[split:])
                )
            self._matrices[lane] = known[key]
        self._keys = keys


def _structure(plant: Network) -> tuple[object, ...]:
    heaters = tuple(name for name, _ in plant.heaters_w)
    places = tuple((each.here, each.there) for each in plant.surfaces)
    tips = tuple((name, each.state) for name, each in plant.feelers.items())
    meters = tuple((name, each.output) for name, each in plant.ammeters.items())
    return plant.nodes, plant.fans, plant.states, heaters, places, tips, meters


class Surfaces:
    """One surface in all lanes."""

    def __init__(self, surfaces: Sequence[Surface]) -> None:
        """Store one surface for each lane."""
        self._here, self._there = surfaces[0].here, surfaces[0].there
        self._factor = np.array([each.factor for each in surfaces])
        self._steps = np.full(len(surfaces), np.nan)
        self._grid = np.zeros(len(surfaces))

    def now(self, vectors: Numbers) -> tuple[Numbers, Numbers]:
        """Return what `Surface.now` returns for each lane, W/K and W."""
        here_c, there_c = vectors[:, self._here], vectors[:, self._there]
        here_k, there_k = here_c + ZERO_C_K, there_c + ZERO_C_K
        exact = self._factor * (here_k * here_k + there_k * there_k) * (here_k + there_k)
        wanted = np.log(exact) / LOG_GRID
        steps = np.rint(wanted)
        # Near the middle of two steps, math.log may round to the other one: recompute the lane.
        steps[np.abs(np.abs(wanted - steps) - 0.5) < _LOG_ERROR] = np.nan
        for lane in np.flatnonzero(steps != self._steps).tolist():
            self._grid[lane] = on_grid(float(exact[lane])) if exact[lane] > 0 else 0.0
        self._steps = steps
        return self._grid, np.where(exact > 0, (exact - self._grid) * (there_c - here_c), 0.0)


_LOG_ERROR = 1e-9
"""Bound on the difference of numpy's logarithm from that of `math`, in steps of the grid."""


class Feelers:
    """The tips of one sensor in all lanes."""

    def __init__(self, feelers: Sequence[Feeler]) -> None:
        """Copy the present state of one tip for each lane."""
        self._state = feelers[0].state
        pasts = [each.past_c for each in feelers]
        longest = max(map(len, pasts))
        self._lanes = np.arange(len(feelers))
        self._past = np.array([[past[0]] * (longest - len(past)) + past for past in pasts])
        """Past temperatures for the dead time, oldest first: a ring that ends at `_end`."""
        self._back = np.array([len(past) for past in pasts])
        self._delayed = self._back > 1
        self._older = np.array([each.older_share for each in feelers])
        self._end = 0
        self._error_k = np.array([each.error_k for each in feelers])
        self._noisy = [lane for lane, each in enumerate(feelers) if each.noise_k]
        self._feelers = [feelers[lane] for lane in self._noisy]
        self._noise_k = np.empty((0, len(self._noisy)))
        """Noise that is drawn but not yet used, one row per step; the last row is used next."""
        self.felt_c = np.array([each.felt_c for each in feelers])

    def feel(self, vectors: Numbers) -> None:
        """Follow the plants by one step."""
        length = self._past.shape[1]
        self._past[:, self._end] = vectors[:, self._state]
        self._end = (self._end + 1) % length
        if length == 1:
            felt_c = self._past[:, 0].copy()
        else:
            oldest = (self._end - self._back) % length
            felt_c = self._past[self._lanes, oldest]
            after = self._past[self._lanes, (oldest + 1) % length]
            mixed = self._older * felt_c + (1 - self._older) * after
            felt_c = np.where(self._delayed, mixed, felt_c)
        felt_c += self._error_k
        if self._noisy:
            if not len(self._noise_k):
                self._noise_k = np.array([each.left_k() for each in self._feelers]).T
            felt_c[self._noisy] += self._noise_k[-1]
            self._noise_k = self._noise_k[:-1]
        self.felt_c = felt_c


class Ammeters:
    """One sensor of a current in all lanes."""

    def __init__(self, meters: Sequence[Ammeter]) -> None:
        """Copy the present state of one current sensor for each lane."""
        self.output = meters[0].output
        self._share = np.array([each.share for each in meters])
        self._full_a = np.array([each.full_a for each in meters])
        self.amperes = np.array([each.amperes for each in meters])

    def follow(self, active: Any) -> None:
        """Advance by one step, with the heater's mean active fraction over it, 0..1."""
        self.amperes = self.amperes + self._share * (active * self._full_a - self.amperes)
