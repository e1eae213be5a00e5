"""The results of a run on the bench."""

import csv
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Series = NDArray[np.float64]
StepLog = NDArray[np.void]
"""One row per control step: `time_s` and the members of the state (docs/control.md)."""

UNITS = (("_k_per_s", "K/s"), ("_percent", "%"), ("_c", "°C"), ("_s", "s"))
"""Units by the end of a member's name."""


@dataclass(frozen=True)
class TraceEvent:
    """An event, for the legend of a plot."""

    time_s: float
    text: str
    disturbs: bool = False
    """Whether it disturbs the machine, not the controller."""


@dataclass(frozen=True)
class Trace:
    """A run: the machine in equal steps of time, the controller in its control steps."""

    times_s: Series
    temperatures_c: Mapping[str, Series]
    """By node of the plant: its temperature, °C."""
    sensed_c: Mapping[str, Series]
    """By sensor: its tip's temperature, °C."""
    on_fraction: Mapping[str, Series]
    """By output: its load's mean share of power (0..1) since the row before, behind the relay."""
    steps: Mapping[str, StepLog]
    """The control steps, by loop."""
    events: tuple[TraceEvent, ...] = ()
    fed_mm_per_s: Series = field(default_factory=lambda: np.zeros(0))
    """Mean speed of the filament since the row before; empty if not recorded."""
    currents_a: Mapping[str, Series] = field(default_factory=dict)
    """By current sensor: its current, A."""

    @property
    def duration_s(self) -> float:
        """The time from the first row to the last, s."""
        return float(self.times_s[-1] - self.times_s[0])

    def write_csv(self, path: Path) -> None:
        """Write one row per step of time, units in the header.

        A loop's columns show its last control step; they are empty before the first.
        """
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(self._header())
            writer.writerows(self._rows())

    def _header(self) -> list[str]:
        return [
            "time [s]",
            *(f"{name} [°C]" for name in self.temperatures_c),
            *(f"{name} sensed [°C]" for name in self.sensed_c),
            *(f"{name} on [1]" for name in self.on_fraction),
            *(f"{name} [A]" for name in self.currents_a),
            *(
                f"{loop}.{with_unit(member)}"
                for loop, log in self.steps.items()
                for member in members(log)
            ),
        ]

    def _rows(self) -> Iterator[list[Any]]:
        world = [
            *self.temperatures_c.values(),
            *self.sensed_c.values(),
            *self.on_fraction.values(),
            *self.currents_a.values(),
        ]
        latest = {
            loop: np.searchsorted(log["time_s"], self.times_s, side="right") - 1
            for loop, log in self.steps.items()
        }
        for row, time_s in enumerate(self.times_s):
            cells = [f"{time_s:.3f}", *(f"{float(series[row]):.6g}" for series in world)]
            for loop, log in self.steps.items():
                cells += _cells(log, int(latest[loop][row]))
            yield cells


def members(log: StepLog) -> tuple[str, ...]:
    """Return the members of the state in a log that are numbers, without the time."""
    names = log.dtype.names or ()
    return tuple(name for name in names if name != "time_s" and log.dtype[name].names is None)


def with_unit(member: str) -> str:
    """Write a member's name with its unit: `temperature_c` → `temperature_c [°C]`."""
    for ending, unit in UNITS:
        if member.endswith(ending):
            return f"{member} [{unit}]"
    return member


def _cells(log: StepLog, row: int) -> list[str]:
    if row < 0:
        return [""] * len(members(log))
    return [f"{log[name][row]:.9g}" for name in members(log)]
