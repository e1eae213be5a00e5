"""The exact response of a network's sensor to a record's power, at any times.

The power is constant between its changes. So each mode of the network follows an exponential
between them, and a dead time only shifts the readings. No time step is needed, and the response is
smooth in every parameter, as a gradient fit needs it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.identify.record import Record
from heatwright.sim.plants.thermal_network import Plant
from heatwright.sim.trace import Series
from heatwright.spec import ThermalNetwork

LEAST_LAG_S = 1e-6
"""Replaces a lag of 0, so that the sensor always has its own state."""

APART = 1e-6
"""Two equal time constants have no separate modes; this relative distance separates them."""

WORST_CONDITION = 1e10


@dataclass(frozen=True)
class Modes:
    """dx/dt = A·x + power·b + ambient·a, seen along the eigenvectors of A."""

    rates: Series
    """Eigenvalues, 1/s, all negative."""
    power: Series
    """Change of each mode per watt of power, K/s."""
    ambient: Series
    """Change of each mode per degree of ambient temperature, 1/s."""
    inward: NDArray[np.float64]
    """Matrix that converts states to modes."""
    reading: Series
    """Weight of each mode in the reading."""


def modes(network: ThermalNetwork, heater: str, sensor: str) -> Modes:
    """Return the modes of a thermal network."""
    sense = network.sense[sensor]
    lag_s = max(sense.lag_s, LEAST_LAG_S)
    for _ in range(8):
        slow = network.model_copy(
            update={"sense": {sensor: sense.model_copy(update={"lag_s": lag_s})}}
        )
        plant = Plant(slow, {heater: 1.0}, ambient_c=0.0, step_s=1.0)
        equations = plant.rates(())
        size = len(equations)
        rates, vectors = np.linalg.eig(equations[:, :size])
        if np.linalg.cond(vectors) < WORST_CONDITION:
            break
        lag_s *= 1 + APART
    inward = np.linalg.inv(vectors)
    return Modes(
        np.real(rates),
        np.real(inward @ equations[:, size]),
        np.real(inward @ equations[:, -1]),
        np.real(inward),
        np.real(vectors[plant.state_of(sensor)]),
    )


class Answer:
    """The power of a record over time, prepared to compute a plant's response."""

    def __init__(
        self, record: Record, before_w: float, rows: NDArray[np.intp] | None = None
    ) -> None:
        """Use the power of a record.

        record -- gives power and times; before_w -- power before the record, W; rows -- the rows
        whose readings are wanted; all if None.
        """
        levels = np.concatenate(([before_w], record.powers_w))
        changes = np.flatnonzero(np.diff(levels))
        self._switched_s = record.times_s[changes]
        self._levels_w = np.concatenate(([before_w], record.powers_w[changes]))
        self._times_s = record.times_s if rows is None else record.times_s[rows]

    def readings(
        self, found: Modes, late_s: float, ambient_c: float, start_c: Series | None
    ) -> Series:
        """Return the sensor's readings.

        found -- the network; late_s -- dead time and age of the readings, s; ambient_c -- ambient
        temperature, °C; start_c -- states of the network a time `late_s` before the first row, °C;
        None: the steady state under the power before the record.
        """
        switched_s = self._switched_s + late_s
        place = np.searchsorted(switched_s, self._times_s, side="right")
        begun_s = np.concatenate(([0.0], switched_s))
        since_s = self._times_s - begun_s[place]
        reading = np.zeros(len(self._times_s))
        start = None if start_c is None else found.inward @ start_c
        for mode, rate in enumerate(found.rates):
            ends = -(found.power[mode] * self._levels_w + found.ambient[mode] * ambient_c) / rate
            first = float(ends[0] if start is None else start[mode])
            values = _course(first, ends, np.exp(rate * np.diff(begun_s)))
            course = ends[place] + (values[place] - ends[place]) * np.exp(rate * since_s)
            reading += found.reading[mode] * course
        return reading


def _course(start: float, ends: Series, shares: Series) -> Series:
    """Return a mode's value at each change: it approaches `ends`; `shares` of the way are left."""
    value, values = start, [start]
    for end, share in zip(ends.tolist(), shares.tolist(), strict=False):
        value = end + (value - end) * share
        values.append(value)
    return np.array(values)
