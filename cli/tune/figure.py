"""Figure of the methods: Bode diagram of the open loop, and the trial in the closed loop."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from heatwright.cli.tune.methods import OWN, ROBUST, Judged, Task, Tried
from heatwright.sim.plots.plot import PANEL_IN, dress
from heatwright.sim.plots.plot_data import SETPOINT, TimeAxis, eventful_s, time_axis, with_reading
from heatwright.sim.trace import StepLog

COLOURS = {
    OWN: "#7f7f7f", "relay": "#0050a0", "simc": "#e69f00", "lambda": "#009e73", ROBUST: "#cc79a7",
}  # fmt: skip
WIDTH_IN = 12.0


Tuned = tuple[Task, Sequence[Judged], Mapping[str, Tried]]
"""A loop, the gains found for it, and their trials."""


def tuned_figure(loops: Sequence[Tuned]) -> Figure:
    """Draw for each loop the Bode diagrams on the left, temperature and duty on the right."""
    figure = Figure(figsize=(WIDTH_IN, 3 * PANEL_IN * len(loops)), layout="constrained")
    parts = figure.subfigures(len(loops), 1, squeeze=False).flatten().tolist()
    for part, loop in zip(parts, loops, strict=True):
        _draw(part, *loop)
    return figure


def _draw(
    figure: SubFigure, task: Task, rows: Sequence[Judged], tried: Mapping[str, Tried]
) -> None:
    panels = figure.subplots(2, 2, sharex="col")
    shown_s = shown_for_s(task, tried)
    time = time_axis(shown_s)
    for row in rows:
        colour = COLOURS[row.method]
        _bode(panels[0][0], panels[1][0], task, row, colour)
        if row.method in tried:
            _course(panels[0][1], panels[1][1], _log(task, tried[row.method]), time, colour)
    _finish_bode(panels[0][0], panels[1][0])
    _finish_course(panels[0][1], panels[1][1], task)
    panels[1][1].set_xlim(0, shown_s / time.seconds)
    panels[1][1].set_xlabel(f"time [{time.unit}]")
    for panel in panels.flatten().tolist():
        dress(panel)
    title = task.controller.identity.title or task.controller.identity.name
    figure.suptitle(f"{title}: {task.loop}", x=0.01, ha="left", fontweight="bold", parse_math=False)


def _bode(size: Axes, angle: Axes, task: Task, row: Judged, colour: str) -> None:
    loop = task.open_loop(row.gains)
    size.loglog(loop.omega, np.abs(loop.response), color=colour, lw=1.4, label=row.method)
    phase = np.degrees(np.unwrap(np.angle(loop.response)))
    angle.semilogx(loop.omega, phase, color=colour, lw=1.4)
    found = row.margins
    if found.crossover:
        at = float(np.interp(found.crossover, loop.omega, phase))
        angle.plot([found.crossover], [at], "o", color=colour, ms=5)


def _finish_bode(size: Axes, angle: Axes) -> None:
    size.axhline(1.0, color=SETPOINT, lw=0.8, ls="--")
    angle.axhline(-180.0, color=SETPOINT, lw=0.8, ls="--")
    angle.set_ylim(-360, 0)
    angle.set_yticks(range(-360, 1, 90))
    size.set_ylabel("open loop, magnitude")
    angle.set_ylabel("phase [°], dots: crossover")
    angle.set_xlabel("frequency [rad/s]")
    size.legend(loc="lower left", frameon=False)


def shown_for_s(task: Task, tried: Mapping[str, Tried]) -> float:
    """Return the length of the trials to draw: 1.5 times the time until all have settled.

    All trials run as long as the slowest machine may need, which can be many times longer.
    """
    eventful = [eventful_s(_log(task, each)) for each in tried.values()]
    whole = [each.trace.duration_s for each in tried.values()]
    return min(max(whole, default=1.0), 1.5 * max(eventful, default=1.0))


def _log(task: Task, tried: Tried) -> StepLog:
    return with_reading(tried.trace.steps[task.loop])


def _course(above: Axes, below: Axes, seen: StepLog, time: TimeAxis, colour: str) -> None:
    times = time(seen["time_s"])
    above.plot(times, seen["temperature_c"], color=colour, lw=1.2)
    below.plot(times, seen["duty_percent"], color=colour, lw=0.9)


def _finish_course(above: Axes, below: Axes, task: Task) -> None:
    above.axhline(task.target_c, color=SETPOINT, lw=0.8, ls="--")
    above.set_ylabel("reading [°C]")
    below.set_ylabel("duty [%]")
    below.set_ylim(0, 105)
