"""The error of each analog sensor's chain: the binary's own table against the exact curve.

The table's error: for every sum of ADC codes, the table's temperature minus that of the middle of
the codes' step; its bound is half a step of the ADC. The chain's error: for every temperature, the
firmware's reading minus that temperature; its bound is one step. A current's table is a line, from
no current to the ADC's full scale.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.binary.elf import Elf
from heatwright.sim.circuits import current_v, reference_v, shares
from heatwright.sim.circuits.elements import Array
from heatwright.spec import Analog, Board, Controller, CurrentSensor, Rtd, Thermistor

TABLE_BOUND_STEPS = 0.5
CHAIN_BOUND_STEPS = 1.0


@dataclass(frozen=True)
class ChainRow:
    """The chain at one temperature, °C (current, A).

    step -- the size of one ADC step there; error -- the largest error near it; both in K (A).
    """

    at: float
    step: float
    error: float


@dataclass(frozen=True)
class ChainError:
    """The errors of one sensor.

    points -- number of points of its table; table_steps -- the table's largest error, in steps of
    the ADC; chain_steps, chain_error -- the whole chain's, in steps and in K (A); rows -- the chain
    over its range; measures -- what the sensor measures.
    """

    sensor: str
    points: int
    table_steps: float
    chain_steps: float
    chain_error: float
    rows: tuple[ChainRow, ...]
    measures: Literal["temperature", "current"] = "temperature"

    @property
    def passed(self) -> bool:
        """Whether both errors are within the bounds that follow from the ADC's resolution."""
        return self.table_steps < TABLE_BOUND_STEPS and self.chain_steps <= CHAIN_BOUND_STEPS

    def as_json(self) -> dict[str, Any]:
        """Return the result as JSON data: temperatures in °C, errors in K (A) and steps."""
        unit = "k" if self.measures == "temperature" else "a"
        return {
            "sensor": self.sensor,
            "points": self.points,
            "table_steps": round(self.table_steps, 4),
            "chain_steps": round(self.chain_steps, 4),
            f"chain_{unit}": round(self.chain_error, 4),
            "rows": [
                {self.measures: round(row.at, 2), f"step_{unit}": round(row.step, 4),
                 f"error_{unit}": round(row.error, 4)}
                for row in self.rows
            ],
        }  # fmt: skip


CODES = 1024
LOOKS_PER_STEP = 200
"""Number of temperatures tested within each step of the ADC, on average."""
SHOWN = 7
"""Number of temperatures in the printed table."""
NEAR_STEPS = 1.0
"""A printed row has the largest error within this distance, so that both ends of a step count."""

POINT = np.dtype([("raw", "<i2"), ("celsius", "<f4"), ("k_per_count", "<f4")])
"""One point of a table in the firmware's flash."""
LINE = np.dtype([("at_zero", "<f4"), ("per_count", "<f4")])
"""The line of a current in the firmware's flash: A, and A per count."""


def chain_errors(controller: Controller, elf: Elf | Path) -> Iterator[ChainError]:
    """Yield the errors of each analog sensor. Raises ElfError: the binary has no table."""
    for name, sensor in controller.adc_sensors.items():
        program = elf if isinstance(elf, Elf) else Elf(elf)
        if not sensor.measures_current:
            yield _Temperature(sensor, controller.board, table_of(program, name)).errors(name)
        else:
            yield _Current(sensor, controller.board, line_of(program, name)).errors(name)


def table_of(program: Elf, sensor: str) -> NDArray[Any]:
    """Return the points of a sensor's table, as the firmware reads them from its flash."""
    symbol = f"sensor_{sensor}_points"
    return np.frombuffer(program.flash_bytes(symbol, program.size_of(symbol)), POINT)


def line_of(program: Elf, sensor: str) -> NDArray[Any]:
    """Return the line of a current sensor, as the firmware reads it from its flash."""
    symbol = f"sensor_{sensor}_line"
    return np.frombuffer(program.flash_bytes(symbol, program.size_of(symbol)), LINE)


def convert(table: NDArray[Any], raw: NDArray[np.int_]) -> NDArray[np.float32]:
    """Convert sums of codes to °C in the firmware's arithmetic, single precision throughout."""
    place = np.clip(np.searchsorted(table["raw"], raw, side="right") - 1, 0, len(table) - 1)
    counts = (raw - table["raw"][place]).astype(np.float32)
    converted: NDArray[np.float32] = table["celsius"][place] + counts * table["k_per_count"][place]
    return converted


class _Chain(ABC):
    """The firmware's conversion of sums of codes, compared with the true values."""

    many: int
    """Number of ADC codes that the firmware sums for a reading."""
    range: tuple[float, float]
    points: int
    measures: Literal["temperature", "current"]

    @abstractmethod
    def made(self, raw: NDArray[np.int_]) -> Array:
        """Return the temperatures or currents that the firmware computes from sums of codes."""

    @abstractmethod
    def steps(self, value: Array) -> Array:
        """Return the voltage at the ADC for temperatures or currents, in ADC steps from 0 V."""

    def errors(self, name: str) -> ChainError:
        """Test all sums, and values so close together that both ends of each step are tested."""
        low, high = (int(code) for code in np.sort(np.floor(self.steps(np.array(self.range)))))
        values = np.linspace(*self.range, LOOKS_PER_STEP * (high - low + 1))
        exact = self.steps(values)
        made = self.made(self.many * np.floor(exact).astype(int))
        error = np.abs(made - values)
        return ChainError(
            name,
            self.points,
            self._table_steps(low, high),
            float(np.abs(self.steps(made) - exact).max()),
            float(error.max()),
            tuple(self._rows(values, exact, error)),
            self.measures,
        )

    def _table_steps(self, low: int, high: int) -> float:
        """Return the table's own error over all sums, in steps of the ADC."""
        raw = np.arange(self.many * low, self.many * high + 1)
        meant = raw / self.many + 0.5
        return float(np.abs(self.steps(self.made(raw)) - meant).max())

    @staticmethod
    def _rows(values: Array, exact: Array, error: Array) -> Iterator[ChainRow]:
        """Yield a row for each of some evenly spaced values."""
        slope = np.abs(np.gradient(exact, values))
        for place in np.linspace(0, len(values) - 1, SHOWN).astype(int):
            near = np.abs(exact - exact[place]) <= NEAR_STEPS
            yield ChainRow(float(values[place]), float(1 / slope[place]), float(error[near].max()))


class _Temperature(_Chain):
    measures = "temperature"

    def __init__(
        self, sensor: Thermistor | Rtd | Analog, board: Board, table: NDArray[Any]
    ) -> None:
        self._sensor, self._board, self._table = sensor, board, table
        self.many, self.range, self.points = sensor.oversample, sensor.range_c, len(table) + 1

    def made(self, raw: NDArray[np.int_]) -> Array:
        return convert(self._table, raw).astype(float)

    def steps(self, value: Array) -> Array:
        return CODES * shares(self._sensor, self._board, value)


class _Current(_Chain):
    measures = "current"
    points = 2

    def __init__(self, sensor: CurrentSensor, board: Board, line: NDArray[Any]) -> None:
        self._sensor, self._line = sensor, line[0]
        self._full_v = reference_v(sensor, board)
        self.many = sensor.oversample
        # The highest code has no upper end: the measurable range ends where that code begins.
        most_v = self._full_v * (CODES - 1) / CODES
        self.range = (0.0, (most_v - sensor.offset_v) / sensor.scale_v_per_a)

    def made(self, raw: NDArray[np.int_]) -> Array:
        line = self._line
        amperes = raw.astype(np.float32) * line["per_count"] + line["at_zero"]
        return np.asarray(np.maximum(amperes, np.float32(0)), float)

    def steps(self, value: Array) -> Array:
        return CODES * current_v(self._sensor, value) / self._full_v
