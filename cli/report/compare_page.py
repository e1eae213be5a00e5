"""The page of a comparison."""

from collections.abc import Sequence
from typing import Any

from heatwright.cli.compare.rows import Outcome
from heatwright.cli.compare.tabled import COLUMNS, half_heights, lines, mismatches, ticks
from heatwright.cli.report.chart_data import colour_of, curve
from heatwright.cli.report.pages import data, page
from heatwright.sim.plots.plot_data import Look, TimeAxis, looks_of, time_axis, with_reading
from heatwright.spec import Spec

PANEL = 110
"""Height of a row's picture in pixels."""


def compare_page(spec: Spec, outcomes: Sequence[Outcome], device: str) -> str:
    """Return the page's HTML; `device` is what was simulated."""
    identity = spec.controller.identity
    replayed = (
        f"{ticks(outcomes)} control steps of the binaries replayed by the reference model: "
        f"{mismatches(outcomes)} mismatches."
    )
    return page(
        "compare.html.j2",
        identity.title or identity.name,
        subtitle=f"{identity.name}: algorithms compared on the {device}",
        data=data(_chart(spec, outcomes)),
        columns=COLUMNS,
        groups=[lines(outcome) for outcome in outcomes],
        published=any(outcome.row.published is not None for outcome in outcomes),
        replayed=replayed if device == "binary" else "",
    )


def _chart(spec: Spec, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    end_s = float(outcomes[0].log["time_s"][-1])
    time = time_axis(end_s)
    looks, halves_k = looks_of(spec.controller.loops), half_heights(outcomes)
    return {
        "unit": time.unit,
        "duration": end_s / time.seconds,
        "panels": [_panel(each, time, halves_k[each.loop], looks[each.loop]) for each in outcomes],
        "marks": [],
    }


def _panel(outcome: Outcome, time: TimeAxis, half_k: float, look: Look) -> dict[str, Any]:
    row, seen = outcome.row, with_reading(outcome.log)
    reading = curve(
        time, seen["time_s"], seen["temperature_c"],
        name=outcome.title, colour=colour_of(look.reading), kind="step", digits=2,
    )  # fmt: skip
    return {
        "height": PANEL,
        "series": [reading],
        "range": (row.setpoint_c - half_k, row.setpoint_c + half_k),
        "bands": [row.published.steady_c] if row.published is not None else [],
    }
