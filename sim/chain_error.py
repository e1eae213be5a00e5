"""The errors found in an analog sensor's chain (see heatwright.sim.chain)."""

from dataclasses import dataclass
from typing import Any, Literal

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
