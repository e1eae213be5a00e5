"""Plot a run: temperatures, a zoom at the setpoint, the heaters' duty, faults."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from heatwright.sim.plots.plot_data import (
    FAULT,
    Look,
    TimeAxis,
    all_faults,
    asked_of,
    band_k,
    closer,
    deviation_k,
    fault_label,
    followed,
    key_presses,
    label_rows,
    looks_of,
    node_colours,
    runs_program,
    time_axis,
    with_reading,
)
from heatwright.sim.trace import StepLog, Trace
from heatwright.spec import Controller, Loop

WIDTH_IN, PANEL_IN, DPI = 10.0, 2.4, 120

LETTERS = 95
"""Number of letters that fit across the plot."""
LABEL_PT = 10
"""Height of a row of labels; labels beyond the panel are left out."""


def save(figure: Figure, path: Path) -> None:
    """Write a figure to a file, in the format of its suffix."""
    figure.savefig(path, format=path.suffix[1:].lower(), dpi=DPI)


def run_figure(trace: Trace, controller: Controller, title: str = "") -> Figure:
    """Draw a run: all temperatures, then for each loop a zoom at its setpoint, and its duty.

    The legend beside the first panel is for all panels.
    """
    looks = looks_of(controller.loops)
    heights = [1.5] + [1.0, 0.6] * len(looks)
    figure = Figure(figsize=(WIDTH_IN, PANEL_IN * sum(heights)), layout="constrained")
    panels: Sequence[Axes] = figure.subplots(
        len(heights), 1, sharex=True, gridspec_kw={"height_ratios": heights}
    )
    time = time_axis(trace.duration_s)
    _temperatures(panels[0], trace, controller, looks, time)
    for number, (loop, look) in enumerate(looks.items()):
        _closer(panels[1 + 2 * number], trace.steps[loop], loop, look, time)
        _duty(panels[2 + 2 * number], trace.steps[loop], controller.loops[loop], look, time)
    for panel in panels:
        dress(panel)
        _mark_faults(panel, trace, time)
    _legend(panels)
    panels[0].set_xlim(0, trace.duration_s / time.seconds)
    panels[-1].set_xlabel(f"time [{time.unit}]")
    panels[0].set_title(title, loc="left", fontweight="bold", parse_math=False)
    return figure


def _temperatures(
    panel: Axes, trace: Trace, controller: Controller, looks: Mapping[str, Look], time: TimeAxis
) -> None:
    colours = node_colours(controller, trace.temperatures_c, looks)
    several = len(looks) > 1
    for node, series in trace.temperatures_c.items():
        panel.plot(
            time(trace.times_s), series, color=colours[node], label=node,
            lw=0.9 if several else 1.2, ls=":" if several else "-",
        )  # fmt: skip
    for loop, log in trace.steps.items():
        _readings(panel, log, f"{controller.loops[loop].sensor} reading", looks[loop], time)
    _label_keys(panel, trace, time)
    panel.set_ylabel("temperature [°C]")


def _legend(panels: Sequence[Axes]) -> None:
    """Write one legend for all panels."""
    shown = [zip(*panel.get_legend_handles_labels(), strict=True) for panel in panels]
    by_label = {label: handle for each in shown for handle, label in each}
    panels[0].legend(
        by_label.values(), by_label.keys(),
        loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False,
    )  # fmt: skip


def _readings(panel: Axes, log: StepLog, label: str, look: Look, time: TimeAxis) -> None:
    seen = with_reading(log)
    panel.step(
        time(seen["time_s"]), seen["temperature_c"], where="post", color=look.reading, lw=1.4,
        label=label,
    )  # fmt: skip
    panel.step(
        time(log["time_s"]), log["setpoint_c"], where="post", color=look.setpoint, lw=1.0, ls="--",
        label=f"{look.prefix}setpoint",
    )  # fmt: skip


def _label_keys(panel: Axes, trace: Trace, time: TimeAxis) -> None:
    presses = key_presses(trace)
    for time_s, _ in presses:
        panel.axvline(time_s / time.seconds, color="#888888", lw=0.6, ls=":", zorder=0)
    _label(panel, presses, time, trace.duration_s, "#666666")


def _label(
    panel: Axes, labels: Sequence[tuple[float, str]], time: TimeAxis, span_s: float, colour: str
) -> None:
    """Write labels beside their lines: those of faults from the bottom up, others from the top."""
    top = colour != FAULT
    most = int(panel.bbox.height * 72 / panel.figure.dpi / LABEL_PT)
    for (time_s, text), (row, late) in zip(
        labels, label_rows(labels, span_s, LETTERS), strict=True
    ):
        if row < most:
            offset = -LABEL_PT * (row + 1) if top else 2 + LABEL_PT * row
            panel.annotate(
                text, (time_s / time.seconds, 1.0 if top else 0.02),
                xycoords=("data", "axes fraction"), xytext=(-3 if late else 3, offset),
                textcoords="offset points", fontsize=8, color=colour,
                fontweight="normal" if top else "bold", ha="right" if late else "left",
            )  # fmt: skip


def _closer(panel: Axes, log: StepLog, loop: str, look: Look, time: TimeAxis) -> None:
    """Draw the readings around the last setpoint, or around a program's moving setpoint."""
    if runs_program(log):
        seen = followed(log)
        panel.axhline(0.0, color=look.setpoint, lw=1.0, ls="--")
        panel.step(
            time(seen["time_s"]), deviation_k(seen), where="post", color=look.reading, lw=1.0
        )
        panel.set_ylim(*band_k(log))
        panel.set_ylabel(f"{loop} − setpoint [K]")
        return
    _readings(panel, log, "", look, time)
    panel.set_ylim(*closer(log))
    panel.set_ylabel(f"{loop}, closer [°C]")


def _duty(panel: Axes, log: StepLog, loop: Loop, look: Look, time: TimeAxis) -> None:
    """Draw the duty of the heater and, if there is one, the cooler."""
    for name, (percent, colour) in asked_of(log, loop, look).items():
        panel.fill_between(
            time(log["time_s"]), percent, step="post", color=colour, alpha=0.8, lw=0,
            label=name if loop.cooler else None,
        )  # fmt: skip
    panel.set_ylim(0, 105)
    panel.set_ylabel(f"{loop.heater} [%]" if loop.cooler is None else "duty [%]")


def _mark_faults(panel: Axes, trace: Trace, time: TimeAxis) -> None:
    tripped = all_faults(trace)
    for time_s, _ in tripped:
        panel.axvline(time_s / time.seconds, color=FAULT, lw=1.2)
    labels = [(time_s, fault_label(code)) for time_s, code in tripped]
    _label(panel, labels, time, trace.duration_s, FAULT)


def dress(panel: Axes) -> None:
    """Reduce the frame of a panel, so that the curves stand out."""
    panel.grid(visible=True, color="#dddddd", lw=0.6)
    panel.set_axisbelow(True)
    for side in ("top", "right"):
        panel.spines[side].set_visible(False)
