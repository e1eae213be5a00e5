"""A run as a picture: temperatures, a closer look at the setpoint, the heaters' duty, faults."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from heatwright.sim.metrics import response_start
from heatwright.sim.trace import Series, StepLog, Trace
from heatwright.spec import Controller
from heatwright.spec.rules import RULES

FORMATS = (".png", ".svg")
"""Kinds of file that `save` writes, by suffix."""

NODES = ("#e69f00", "#009e73", "#56b4e9", "#cc79a7", "#b0a000", "#7f7f7f")
READING = "#0050a0"
SETPOINT = "#202020"
HEAT = "#d55e00"
FAULT = "#c00000"
"""Colours that the colour-blind can tell apart (Okabe & Ito, Color Universal Design, 2008)."""

WIDTH_IN, PANEL_IN, DPI = 10.0, 2.4, 120

LEAST_ZOOM_K = 0.5
"""Half of the least height of the closer look: eight steps of a 12 bit sensor."""

TIME_UNITS = (("h", 3600.0, 3 * 3600.0), ("min", 60.0, 300.0), ("s", 1.0, 0.0))
"""Unit of the time axis, its seconds, and the length of a run from which on it is used."""

Tripped = tuple[float, int]
"""Time, s, and code of a fault."""


@dataclass(frozen=True)
class TimeAxis:
    """Seconds in the unit of the axis."""

    unit: str
    seconds: float

    def __call__(self, times_s: Series) -> Series:
        """Scale times."""
        return times_s / self.seconds


def time_axis(duration_s: float) -> TimeAxis:
    """Choose the unit for a run."""
    unit, seconds = next((unit, size) for unit, size, start in TIME_UNITS if duration_s >= start)
    return TimeAxis(unit, seconds)


def faults(log: StepLog) -> tuple[Tripped, ...]:
    """Return when faults tripped, and their codes."""
    codes = log["fault.code"].astype(int)
    risen = np.flatnonzero((codes != 0) & (np.diff(codes, prepend=0) != 0))
    return tuple((float(log["time_s"][row]), int(codes[row])) for row in risen)


def save(figure: Figure, path: Path) -> None:
    """Write a figure to a file of the kind its suffix names."""
    figure.savefig(path, format=path.suffix[1:].lower(), dpi=DPI)


def run_figure(trace: Trace, controller: Controller, title: str = "") -> Figure:
    """Draw a run: all temperatures, then for each loop its setpoint closer and its duty."""
    loops = tuple(controller.loops)
    heights = [1.5] + [1.0, 0.6] * len(loops)
    figure = Figure(figsize=(WIDTH_IN, PANEL_IN * sum(heights)), layout="constrained")
    panels: Sequence[Axes] = figure.subplots(
        len(heights), 1, sharex=True, gridspec_kw={"height_ratios": heights}
    )
    time = time_axis(trace.duration_s)
    _temperatures(panels[0], trace, controller, time)
    for number, loop in enumerate(loops):
        _closer(panels[1 + 2 * number], trace.steps[loop], loop, time)
        _duty(panels[2 + 2 * number], trace.steps[loop], controller.loops[loop].heater, time)
    for panel in panels:
        _dress(panel)
        for loop in loops:
            _mark_faults(panel, trace.steps[loop], time)
    panels[0].set_xlim(0, trace.duration_s / time.seconds)
    panels[-1].set_xlabel(f"time [{time.unit}]")
    panels[0].set_title(title, loc="left", fontweight="bold")
    return figure


def _temperatures(panel: Axes, trace: Trace, controller: Controller, time: TimeAxis) -> None:
    for colour, (node, series) in zip(_cycle(NODES), trace.temperatures_c.items(), strict=False):
        panel.plot(time(trace.times_s), series, color=colour, lw=1.2, label=node)
    for loop, log in trace.steps.items():
        _readings(panel, log, f"{controller.loops[loop].sensor} reading", time)
    for event in trace.events:
        panel.axvline(event.time_s / time.seconds, color="#888888", lw=0.6, ls=":", zorder=0)
    _label_events(panel, trace, time)
    panel.set_ylabel("temperature [°C]")
    panel.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)


def _readings(panel: Axes, log: StepLog, label: str, time: TimeAxis) -> None:
    seen = log[log["has_reading"] != 0]
    panel.step(
        time(seen["time_s"]), seen["temperature_c"], where="post", color=READING, lw=1.4, label=label
    )
    panel.step(
        time(log["time_s"]), log["setpoint_c"], where="post", color=SETPOINT, lw=1.0, ls="--",
        label="setpoint",
    )  # fmt: skip


def _label_events(panel: Axes, trace: Trace, time: TimeAxis) -> None:
    """Name the operator's keys; presses that follow at once are one label."""
    groups: list[tuple[float, str, int]] = []
    for event in trace.events:
        if groups and groups[-1][1] == event.text and event.time_s - _end(groups[-1]) < 1.0:
            start_s, text, times = groups.pop()
            groups.append((start_s, text, times + 1))
        else:
            groups.append((event.time_s, event.text, 1))
    for start_s, text, times in groups:
        label = text if times == 1 else f"{text} ×{times}"
        panel.annotate(
            label, (start_s / time.seconds, 1.0), xycoords=("data", "axes fraction"),
            xytext=(3, -10), textcoords="offset points", fontsize=8, color="#666666",
        )  # fmt: skip


def _end(group: tuple[float, str, int]) -> float:
    return group[0] + 0.2 * (group[2] - 1)


def _closer(panel: Axes, log: StepLog, loop: str, time: TimeAxis) -> None:
    """Show the readings around the last setpoint, once they have come near it."""
    _readings(panel, log, "reading", time)
    response = log[response_start(log) :]
    setpoint_c = float(response["setpoint_c"][-1])
    panel.set_ylim(*zoom(response["temperature_c"].astype(float), setpoint_c))
    panel.set_ylabel(f"{loop}, closer [°C]")


def zoom(readings_c: Series, setpoint_c: float) -> tuple[float, float]:
    """Choose the height of the closer look: what the readings do once they have first arrived."""
    errors_k = readings_c - setpoint_c
    arrived = np.flatnonzero(np.diff(np.sign(errors_k)) != 0)
    start = int(arrived[0]) if len(arrived) else 2 * len(errors_k) // 3
    half_k = max(LEAST_ZOOM_K, 1.15 * float(np.abs(errors_k[start:]).max(initial=0.0)))
    return setpoint_c - half_k, setpoint_c + half_k


def _duty(panel: Axes, log: StepLog, heater: str, time: TimeAxis) -> None:
    panel.fill_between(
        time(log["time_s"]), log["duty_percent"], step="post", color=HEAT, alpha=0.8, lw=0
    )
    panel.set_ylim(0, 105)
    panel.set_ylabel(f"{heater} [%]")


def _mark_faults(panel: Axes, log: StepLog, time: TimeAxis) -> None:
    for time_s, code in faults(log):
        panel.axvline(time_s / time.seconds, color=FAULT, lw=1.2)
        panel.annotate(
            f"E{code:02d} {RULES[code].display}", (time_s / time.seconds, 0.02),
            xycoords=("data", "axes fraction"), xytext=(4, 2), textcoords="offset points",
            fontsize=8, color=FAULT, fontweight="bold",
        )  # fmt: skip


def _dress(panel: Axes) -> None:
    panel.grid(visible=True, color="#dddddd", lw=0.6)
    panel.set_axisbelow(True)
    for side in ("top", "right"):
        panel.spines[side].set_visible(False)


def _cycle(colours: Sequence[str]) -> Iterator[Any]:
    while True:
        yield from colours
