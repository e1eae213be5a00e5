"""The page of a campaign."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from heatwright.cli.campaign.shown import (
    SPREAD_COLUMNS,
    WORDS,
    Campaign,
    spread_cells,
    vary_text,
    worst_cells,
)
from heatwright.cli.campaign.summary import SHOWN, numbers, titled, unit_of
from heatwright.cli.report.pages import data, page
from heatwright.sim.campaign.outcome import UNNOTICED, WELL, Row

MOST_BINS = 40
HEIGHT = 150
"""Height of a picture, in pixels."""


def campaign_page(done: Campaign, rows: Sequence[Row]) -> str:
    """Return the page's HTML."""
    controller, summary = done.spec.controller, done.summary
    identity = controller.identity
    well = [row for row in rows if row["outcome"] == WELL]
    nodes = [name for name in rows[0] if name.startswith("peak.")]
    return page(
        "campaign.html.j2",
        identity.title or identity.name,
        subtitle=f"{identity.name}: {summary.runs} machines drawn from seed {done.seed}, run by "
        "the binary",
        outcomes=[(WORDS[word], str(count)) for word, count in summary.outcomes.items()],
        failures=_failures(done),
        vary_text=vary_text(done.vary_file),
        varied=list(done.vary.lines()),
        figures=[
            (titled(column), chart)
            for column in (f"loop.{loop}.{name}" for loop in controller.loops for name in SHOWN)
            if (chart := _histogram(well, column, "runs without a fault"))
        ],
        peaks=[
            (titled(column), chart)
            for column in nodes if (chart := _histogram(rows, column, "all runs"))
        ],
        trip_chart=_histogram(rows, "tripped_after_s", "runs with a fault"),
        columns=SPREAD_COLUMNS,
        figure_rows=[spread_cells(each) for each in summary.figures],
        peak_rows=[spread_cells(each) for each in summary.peaks],
        trip_rows=[spread_cells(each) for each in summary.trips],
        worst_columns=("worst", "", "repeat the run"),
        worst_rows=worst_cells(done),
        digest=done.spec.digest,
    )  # fmt: skip


def _failures(done: Campaign) -> list[str]:
    summary = done.summary
    found = [f"{rule} tripped in {count} runs, with nothing broken"
             for rule, count in summary.rules.items()]  # fmt: skip
    found += [f"{node} became hotter than its limit (bears) in {count} runs"
              for node, count in summary.too_hot.items()]  # fmt: skip
    if unnoticed := summary.outcomes[UNNOTICED]:
        found.append(f"no rule tripped in {unnoticed} runs in which something broke")
    return found


def _histogram(rows: Sequence[Row], column: str, whose: str) -> Any:
    """Draw the histogram of a column's values; None if there are no values."""
    values = numbers(rows, column)
    if not values:
        return None
    low, high = min(values), max(values)
    if high - low < 1e-9:  # all values are equal: one bar
        low, high = low - 0.5, high + 0.5
    bins = min(MOST_BINS, max(5, round(2 * len(values) ** (1 / 3))))
    counts, edges = np.histogram(values, bins=bins, range=(low, high))
    bars = {
        "name": f"{titled(column)} [{unit_of(column)}], {whose}",
        "colour": "var(--accent)", "kind": "area", "dashed": False, "digits": 0,
        "t": [float(f"{edge:.6g}") for edge in edges.tolist()],
        "v": [*counts.tolist(), 0],
    }  # fmt: skip
    return data({
        "unit": unit_of(column), "start": float(edges[0]), "duration": float(edges[-1]),
        "panels": [{"height": HEIGHT, "series": [bars], "range": (0, 1.08 * float(counts.max()))}],
        "marks": [],
    })  # fmt: skip
