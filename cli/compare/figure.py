"""Figure of a comparison: a small panel for each row, one scale and colour for each loop.

Published figures are drawn behind the curves.
"""

from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from heatwright.cli.compare.rows import Outcome
from heatwright.cli.compare.tabled import half_heights
from heatwright.sim.plots.plot import dress
from heatwright.sim.plots.plot_data import (
    HEAT,
    SETPOINT,
    SHARED,
    Look,
    TimeAxis,
    looks_of,
    time_axis,
    with_reading,
)
from heatwright.sim.trace import Series, StepLog
from heatwright.spec import Published, Spec

COLUMNS = 3
PANEL_IN = (4.0, 2.3)
CROSSINGS = 60
"""Maximum number of crossings of the setpoint that can be distinguished in one panel."""
BINS = 200
CLOSE_CROSSINGS = 8
"""Number of the last crossings, which an inset of the panel enlarges."""
GLASS = (0.5, 0.28, 0.48, 0.44)
"""Place of the enlarged part in its panel: left, lower, width, height."""


def comparison_figure(spec: Spec, outcomes: Sequence[Outcome]) -> Figure:
    """Draw each row's readings around its setpoint; each loop begins a new line of panels."""
    lines = list(_lines(outcomes))
    columns = max(map(len, lines))
    size = (PANEL_IN[0] * columns, PANEL_IN[1] * len(lines) + 0.9)
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(len(lines), columns, squeeze=False, sharex=True)
    looks, halves_k = looks_of(spec.controller.loops), half_heights(outcomes)
    lowest: dict[int, Axes] = {}
    shown: dict[str, Artist] = {}
    for panels, line in zip(grid.tolist(), lines, strict=True):
        panels[0].set_ylabel("reading [°C]")
        for column, panel in enumerate(panels):
            if column >= len(line):
                panel.set_visible(False)
                continue
            loop = line[column].loop
            _draw(panel, line[column], halves_k[loop], looks[loop])
            lowest[column] = panel
            handles, labels = panel.get_legend_handles_labels()
            shown |= dict(zip(labels, handles, strict=True))
    for panel in lowest.values():
        panel.tick_params(labelbottom=True)
        panel.set_xlabel(f"time [{_axis(outcomes[0]).unit}]")
    title = spec.controller.identity.title or spec.controller.identity.name
    figure.suptitle(title, x=0.01, ha="left", fontweight="bold", parse_math=False)
    handles, labels = list(shown.values()), list(shown)
    figure.legend(handles, labels, loc="outside lower right", ncols=4, frameon=False)
    return figure


def _lines(outcomes: Sequence[Outcome]) -> Iterator[tuple[Outcome, ...]]:
    for _, grouped in groupby(outcomes, lambda outcome: outcome.loop):
        of_loop = tuple(grouped)
        for start in range(0, len(of_loop), COLUMNS):
            yield of_loop[start : start + COLUMNS]


def _axis(outcome: Outcome) -> TimeAxis:
    return time_axis(float(outcome.log["time_s"][-1]))


def _draw(panel: Axes, outcome: Outcome, half_k: float, look: Look) -> None:
    row, seen = outcome.row, with_reading(outcome.log)
    time = _axis(outcome)
    times = time(seen["time_s"])
    if row.published is not None:
        colour = SHARED if look.prefix else HEAT
        _published(panel, row.published, float(times[-1]), colour)
    panel.axhline(row.setpoint_c, color=SETPOINT, lw=1.0, ls="--", label="setpoint")
    label = f"{look.prefix}simulated"
    crossings = np.flatnonzero(np.diff(seen["temperature_c"] > row.setpoint_c)) + 1
    if len(crossings) > CROSSINGS and np.ptp(seen["temperature_c"][crossings[0] :]) > half_k / 5:
        _swing(panel, times, seen, look.reading, label)
        _closer(panel, seen, int(crossings[-CLOSE_CROSSINGS]), look.reading, row.setpoint_c)
    else:
        panel.step(
            times, seen["temperature_c"], where="post", color=look.reading, lw=1.2, label=label
        )
    panel.set_ylim(row.setpoint_c - half_k, row.setpoint_c + half_k)
    panel.set_xlim(0, float(times[-1]))
    panel.set_title(outcome.title, loc="left", fontsize=10, parse_math=False)
    panel.tick_params(labelbottom=False)
    dress(panel)


def _swing(panel: Axes, times: Series, seen: StepLog, colour: str, label: str) -> None:
    """Draw the band in which the reading swings; single swings could not be told apart."""
    begins = np.unique(np.linspace(0, len(seen), BINS, endpoint=False).astype(int))
    low_c = np.minimum.reduceat(seen["temperature_c"], begins)
    high_c = np.maximum.reduceat(seen["temperature_c"], begins)
    panel.fill_between(times[begins], low_c, high_c, color=colour, alpha=0.5, lw=0.8, label=label)


def _closer(panel: Axes, seen: StepLog, first: int, colour: str, setpoint_c: float) -> None:
    """Draw the last swings enlarged, in an inset."""
    last = seen[first:]
    took = time_axis(float(last["time_s"][-1] - last["time_s"][0]))
    times = took(last["time_s"] - last["time_s"][0])
    glass = panel.inset_axes(GLASS)
    glass.axhline(setpoint_c, color=SETPOINT, lw=0.8, ls="--")
    glass.step(times, last["temperature_c"], where="post", color=colour, lw=1.0)
    glass.ticklabel_format(axis="y", useOffset=False)
    glass.set_title(f"the last {times[-1]:.3g} {took.unit}", fontsize=7, pad=2)
    glass.tick_params(labelsize=6, labelbottom=False, length=0)
    glass.set_xlim(0, float(times[-1]))


def _published(panel: Axes, published: Published, end: float, colour: str) -> None:
    span = np.array([0.0, end])
    panel.fill_between(
        span, published.steady_minimum_c, published.steady_maximum_c,
        color=colour, alpha=0.2, lw=0, label="published steady range",
    )  # fmt: skip
    panel.axhline(published.maximum_c, color=colour, lw=1.0, ls=":", label="published maximum")
