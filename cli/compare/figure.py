"""The rows of a comparison as small pictures of one scale, with the published figures behind."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from heatwright.cli.compare.rows import Outcome
from heatwright.cli.compare.tabled import half_height
from heatwright.sim.plot import dress
from heatwright.sim.plot_data import READING, SETPOINT, time_axis, with_reading
from heatwright.spec import Published, Spec

COLUMNS = 3
PANEL_IN = (4.0, 2.3)
PUBLISHED = "#d55e00"


def comparison_figure(spec: Spec, outcomes: Sequence[Outcome]) -> Figure:
    """Draw each row's readings around its setpoint."""
    lines = -(-len(outcomes) // COLUMNS)
    columns = min(COLUMNS, len(outcomes))
    size = (PANEL_IN[0] * columns, PANEL_IN[1] * lines + 0.9)
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(lines, columns, squeeze=False, sharex=True).flatten().tolist()
    half_k = half_height(outcomes)
    for panel, outcome in zip(panels, outcomes, strict=False):
        _draw(panel, outcome, half_k)
    for panel in panels[len(outcomes) :]:
        panel.set_visible(False)
    title = spec.controller.identity.title or spec.controller.identity.name
    figure.suptitle(title, x=0.01, ha="left", fontweight="bold", parse_math=False)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower right", ncols=4, frameon=False)
    return figure


def _draw(panel: Axes, outcome: Outcome, half_k: float) -> None:
    row, seen = outcome.row, with_reading(outcome.log)
    time = time_axis(float(seen["time_s"][-1]))
    times = time(seen["time_s"])
    if row.published is not None:
        _published(panel, row.published, float(times[-1]))
    panel.axhline(row.setpoint_c, color=SETPOINT, lw=1.0, ls="--", label="setpoint")
    panel.step(times, seen["temperature_c"], where="post", color=READING, lw=1.2, label="simulated")
    panel.set_ylim(row.setpoint_c - half_k, row.setpoint_c + half_k)
    panel.set_xlim(0, float(times[-1]))
    panel.set_title(f"{row.name}, {row.setpoint_c:g} °C", loc="left", fontsize=10, parse_math=False)
    panel.set_xlabel(f"time [{time.unit}]")
    panel.set_ylabel("reading [°C]")
    panel.label_outer()
    panel.tick_params(labelleft=True)
    dress(panel)


def _published(panel: Axes, published: Published, end: float) -> None:
    span = np.array([0.0, end])
    panel.fill_between(
        span, published.steady_minimum_c, published.steady_maximum_c,
        color=PUBLISHED, alpha=0.2, lw=0, label="published steady range",
    )  # fmt: skip
    panel.axhline(published.maximum_c, color=PUBLISHED, lw=1.0, ls=":", label="published maximum")
