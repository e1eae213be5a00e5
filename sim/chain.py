"""The error of each analog sensor's chain, from the binary's own table against the exact curve.

For every sum of codes the range has: how far the table's temperature is from what the middle of the
codes' step means. For every temperature: how far what the firmware makes of it is from it. Both in
steps of the ADC, whose half is the first one's bound, and whose whole is the second's.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.circuits import shares
from heatwright.sim.circuits.elements import Array
from heatwright.sim.elf import Elf
from heatwright.spec import Analog, Board, Controller, Rtd, Thermistor

CODES = 1024
TABLE_BOUND_STEPS = 0.5
CHAIN_BOUND_STEPS = 1.0
LOOKS_PER_STEP = 200
"""Temperatures looked at, on average, within each step of the ADC."""
SHOWN = 7
"""Temperatures of the printed table."""
NEAR_STEPS = 1.0
"""What a row calls near: one step to either side, so that it meets both ends of a step."""

POINT = np.dtype([("raw", "<i2"), ("celsius", "<f4"), ("k_per_count", "<f4")])
"""One point as the firmware has it in its flash."""


@dataclass(frozen=True)
class ChainRow:
    """The chain at one temperature: how much one step of the ADC is, the largest error near, K."""

    celsius: float
    step_k: float
    error_k: float


@dataclass(frozen=True)
class ChainError:
    """What was found of one sensor.

    points -- of its table; table_steps -- the table's largest error, in steps of the ADC;
    chain_steps, chain_k -- the whole chain's; rows -- how it is over the range.
    """

    sensor: str
    points: int
    table_steps: float
    chain_steps: float
    chain_k: float
    rows: tuple[ChainRow, ...]

    @property
    def passed(self) -> bool:
        """Whether both errors are within what the ADC's resolution makes of them."""
        return self.table_steps < TABLE_BOUND_STEPS and self.chain_steps <= CHAIN_BOUND_STEPS

    def as_json(self) -> dict[str, Any]:
        """Return it for machines; temperatures in °C, differences in K, errors also in steps."""
        return {
            "sensor": self.sensor,
            "points": self.points,
            "table_steps": round(self.table_steps, 4),
            "chain_steps": round(self.chain_steps, 4),
            "chain_k": round(self.chain_k, 4),
            "rows": [
                {"temperature": round(row.celsius, 2), "step_k": round(row.step_k, 4),
                 "error_k": round(row.error_k, 4)}
                for row in self.rows
            ],
        }  # fmt: skip


def chain_errors(controller: Controller, elf: Elf | Path) -> Iterator[ChainError]:
    """Yield the errors of each analog sensor; raises ElfError when the binary has no table."""
    for name, sensor in controller.sensors.items():
        if isinstance(sensor, Thermistor | Rtd | Analog):
            program = elf if isinstance(elf, Elf) else Elf(elf)
            yield _Chain(sensor, controller.board, table_of(program, name)).errors(name)


def table_of(program: Elf, sensor: str) -> NDArray[Any]:
    """Return the points of a sensor's table, as the firmware reads them from its flash."""
    symbol = f"sensor_{sensor}_points"
    return np.frombuffer(program.flash_bytes(symbol, program.size_of(symbol)), POINT)


def convert(table: NDArray[Any], raw: NDArray[np.int_]) -> NDArray[np.float32]:
    """Return °C of sums of codes, in the firmware's arithmetic: single precision throughout."""
    place = np.clip(np.searchsorted(table["raw"], raw, side="right") - 1, 0, len(table) - 1)
    counts = (raw - table["raw"][place]).astype(np.float32)
    converted: NDArray[np.float32] = table["celsius"][place] + counts * table["k_per_count"][place]
    return converted


class _Chain:
    def __init__(
        self, sensor: Thermistor | Rtd | Analog, board: Board, table: NDArray[Any]
    ) -> None:
        self._sensor, self._board, self._table = sensor, board, table
        ends = self._steps(np.array(sensor.range_c))
        self._low, self._high = (int(code) for code in np.sort(np.floor(ends)))

    def _steps(self, celsius: Array) -> Array:
        """Return where temperatures are on the ADC, in steps from zero volts."""
        return CODES * shares(self._sensor, self._board, celsius)

    def errors(self, name: str) -> ChainError:
        """Look at all sums, and at temperatures close enough to meet both ends of each step."""
        looks = LOOKS_PER_STEP * (self._high - self._low + 1)
        celsius = np.linspace(*self._sensor.range_c, looks)
        exact = self._steps(celsius)
        many = self._sensor.oversample
        made_c = convert(self._table, many * np.floor(exact).astype(int)).astype(float)
        error_k = np.abs(made_c - celsius)
        error_steps = np.abs(self._steps(made_c) - exact)
        return ChainError(
            name,
            len(self._table) + 1,
            self._table_steps(),
            float(error_steps.max()),
            float(error_k.max()),
            tuple(self._rows(celsius, exact, error_k)),
        )

    def _table_steps(self) -> float:
        """Return the table's own error over all sums, in steps of the ADC."""
        many = self._sensor.oversample
        raw = np.arange(many * self._low, many * self._high + 1)
        meant = raw / many + 0.5
        return float(np.abs(self._steps(convert(self._table, raw).astype(float)) - meant).max())

    def _rows(self, celsius: Array, exact: Array, error_k: Array) -> Iterator[ChainRow]:
        """Yield a row for each of some even temperatures."""
        slope = np.abs(np.gradient(exact, celsius))
        for place in np.linspace(0, len(celsius) - 1, SHOWN).astype(int):
            near = np.abs(exact - exact[place]) <= NEAR_STEPS
            yield ChainRow(
                float(celsius[place]), float(1 / slope[place]), float(error_k[near].max())
            )
