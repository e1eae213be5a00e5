"""Summary of a campaign: quantiles, and the worst of its runs."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from heatwright.sim.campaign.outcome import CAUGHT, TRIPPED, UNNOTICED, WELL, Row

QUANTILES = (0.0, 0.05, 0.5, 0.95, 1.0)
QUANTILE_NAMES = ("least", "5 %", "median", "95 %", "most")
SHOWN = ("overshoot_k", "settling_s", "steady_error_k", "maximum_c")
"""Figures of each loop that the summary shows; the table has all."""
MOST_CASES = 3
"""Maximum number of runs that are listed for each kind of unwanted result."""


class Quantiles(NamedTuple):
    """How a figure spreads.

    what -- the figure, or the fault; having -- runs with a value; of -- runs that could have one.
    """

    what: str
    unit: str
    having: int
    of: int
    values: tuple[float, ...]


class Worst(NamedTuple):
    """A run worth looking at; value -- as text, with its unit."""

    what: str
    value: str
    run: int


@dataclass(frozen=True)
class Summary:
    """The whole summary.

    outcomes -- number of runs by outcome; rules -- number of runs in which the rule tripped without
    a fault; too_hot -- number of runs in which the node became too hot.
    """

    runs: int
    outcomes: dict[str, int]
    rules: dict[str, int]
    too_hot: dict[str, int]
    figures: tuple[Quantiles, ...]
    peaks: tuple[Quantiles, ...]
    trips: tuple[Quantiles, ...]
    worst: tuple[Worst, ...]


def summarised(rows: Sequence[Row], loops: Sequence[str]) -> Summary:
    """Summarise runs, in the order of their numbers."""
    well = [row for row in rows if row["outcome"] == WELL]
    tripped = [row for row in rows if row["outcome"] == TRIPPED]
    hot = [row for row in rows if row["too_hot"] is not None]
    nodes = [name for name in rows[0] if name.startswith("peak.")]
    figures = [f"loop.{loop}.{name}" for loop in loops for name in SHOWN]
    found = Counter(str(row["outcome"]) for row in rows)
    return Summary(
        runs=len(rows),
        outcomes={word: found[word] for word in (WELL, TRIPPED, CAUGHT, UNNOTICED)},
        rules=_count(row["rule"] for row in tripped),
        too_hot=_count(row["too_hot"] for row in hot),
        figures=tuple(_quantiles(name, well) for name in figures),
        peaks=tuple(_quantiles(name, rows) for name in nodes),
        trips=tuple(_trips(rows)),
        worst=tuple(_worst(rows, well, figures, nodes)),
    )


def numbers(rows: Iterable[Row], column: str) -> list[float]:
    """Return the numbers of a column, without empty cells."""
    return [float(value) for row in rows if isinstance(value := row[column], int | float)]


def unit_of(column: str) -> str:
    """Return the unit of a column, by the end of its name."""
    ends = {"k": "K", "s": "s", "c": "°C", "j": "J", "percent": "%"}
    return ends.get(column.rpartition("_")[2], "")


def titled(column: str) -> str:
    """Write a column without kind and unit: `loop.air.overshoot_k` as `air overshoot`."""
    words = column.removeprefix("loop.").removeprefix("peak.")
    if unit_of(column):
        words = words.rpartition("_")[0]
    return words.replace(".", " ").replace("_", " ")


def _count(values: Iterable[object]) -> dict[str, int]:
    return dict(sorted(Counter(map(str, values)).items()))


def _quantiles(column: str, rows: Sequence[Row]) -> Quantiles:
    return _spread(titled(column), unit_of(column), numbers(rows, column), len(rows))


def _spread(what: str, unit: str, values: list[float], of: int) -> Quantiles:
    found = tuple(np.quantile(values, QUANTILES).tolist()) if values else ()
    return Quantiles(what, unit, len(values), of, found)


def _trips(rows: Sequence[Row]) -> Iterable[Quantiles]:
    """Yield the quantiles of the time to trip, for each fault on each loop."""
    broken = [row for row in rows if row["outcome"] in {CAUGHT, UNNOTICED}]
    kinds = sorted({(str(row["drawn.fault.loop"]), str(row["drawn.fault"])) for row in broken})
    for loop, fault in kinds:
        mine = [
            row for row in broken if (row["drawn.fault.loop"], row["drawn.fault"]) == (loop, fault)
        ]
        yield _spread(f"{loop} {fault}", "s", numbers(mine, "tripped_after_s"), len(mine))


def _worst(
    rows: Sequence[Row], well: Sequence[Row], figures: Sequence[str], nodes: Sequence[str]
) -> Iterable[Worst]:
    yield from _odd(rows)
    for column in figures:
        if column.endswith(".settling_s"):
            never = [row for row in well if row[column] is None]
            yield from (_case(f"{titled(column)}: never", "–", row) for row in never[:MOST_CASES])
        yield from _most(f"most {titled(column)}", column, well)
    for column in nodes:
        yield from _most(f"hottest {titled(column)}", column, rows)
    yield from _most("latest trip", "tripped_after_s", rows)


def _odd(rows: Sequence[Row]) -> Iterable[Worst]:
    """Yield runs with an unwanted result: a needless trip, an undetected fault, a node too hot."""
    kinds = (
        ("tripped with nothing broken", "outcome", TRIPPED, "rule"),
        ("broken, and nothing tripped", "outcome", UNNOTICED, "drawn.fault"),
    )
    for what, column, word, told in kinds:
        found = [row for row in rows if row[column] == word]
        yield from (_case(what, str(row[told]), row) for row in found[:MOST_CASES])
    hot = [row for row in rows if row["too_hot"] is not None]
    yield from (_case("above its limit", str(row["too_hot"]), row) for row in hot[:MOST_CASES])


def _case(what: str, value: str, row: Row) -> Worst:
    return Worst(what, value, int(row["run"] or 0))


def _most(what: str, column: str, rows: Sequence[Row]) -> Iterable[Worst]:
    having = [row for row in rows if isinstance(row[column], int | float)]
    if having:
        row = max(having, key=lambda each: float(each[column] or 0.0))
        yield _case(what, f"{float(row[column] or 0.0):.4g} {unit_of(column)}".strip(), row)
