"""A run as the data that `chart.js` draws."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.plots.plot_data import (
    READING,
    SETPOINT,
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
    looks_of,
    node_colours,
    runs_program,
    thinned,
    time_axis,
    with_reading,
)
from heatwright.sim.trace import StepLog, Trace
from heatwright.spec import Controller

MOST_POINTS = 4000
"""Maximum number of points of a curve: four for each pixel column of a wide window."""

TALL, MIDDLE, LOW = 260, 170, 90
"""Heights of panels in pixels."""

Json = dict[str, Any]


def run_chart(trace: Trace, controller: Controller) -> Json:
    """Draw all temperatures, and for each loop the range around its setpoint and its duty."""
    time = time_axis(trace.duration_s)
    looks = looks_of(controller.loops)
    panels = [_panel(TALL, _temperatures(trace, controller, looks, time))]
    for loop, log in trace.steps.items():
        panels.append(_closer(log, looks[loop], time))
        shares = asked_of(log, controller.loops[loop], looks[loop])
        asked = [
            curve(
                time, log["time_s"], percent,
                name=f"{name} [%]", colour=colour, kind="area", digits=1,
            )
            for name, (percent, colour) in shares.items()
        ]  # fmt: skip
        panels.append(_panel(LOW, asked, (0.0, 105.0)))
    return {
        "unit": time.unit,
        "duration": trace.duration_s / time.seconds,
        "panels": panels,
        "marks": [
            *(_mark(time_s, text, time, fault=False) for time_s, text in key_presses(trace)),
            *(_mark(at_s, fault_label(code), time, fault=True) for at_s, code in all_faults(trace)),
        ],
    }


def _closer(log: StepLog, look: Look, time: TimeAxis) -> Json:
    """Draw the readings around the last setpoint; with a program, around each step's setpoint."""
    if not runs_program(log):
        return _panel(MIDDLE, list(readings(log, f"{look.prefix}reading", look, time)), closer(log))
    seen = followed(log)
    deviation = curve(
        time, seen["time_s"], deviation_k(seen),
        name=f"{look.prefix}reading − setpoint [K]", colour=colour_of(look.reading), kind="step",
        digits=2,
    )  # fmt: skip
    return _panel(MIDDLE, [deviation], band_k(log))


def colour_of(of: str) -> str:
    """Return a curve's colour; a single loop has colours for light and for dark pages."""
    return {READING: "var(--accent)", SETPOINT: "var(--ink)"}.get(of, of)


def _panel(height: int, series: list[Json], span: tuple[float, float] | None = None) -> Json:
    return {"height": height, "series": series, "range": span}


def _temperatures(
    trace: Trace, controller: Controller, looks: Mapping[str, Look], time: TimeAxis
) -> list[Json]:
    colours = node_colours(controller, trace.temperatures_c, looks)
    nodes = [
        curve(
            time, trace.times_s, series,
            name=f"{node} [°C]", colour=colour_of(colours[node]), kind="line", digits=1,
        )
        for node, series in trace.temperatures_c.items()
    ]  # fmt: skip
    for loop, log in trace.steps.items():
        sensor = controller.loops[loop].sensor
        nodes += readings(log, f"{sensor} reading", looks[loop], time)
    return nodes


def readings(log: StepLog, name: str, look: Look, time: TimeAxis) -> Iterator[Json]:
    """Draw a loop's readings and its setpoint."""
    seen = with_reading(log)
    yield curve(
        time, seen["time_s"], seen["temperature_c"],
        name=f"{name} [°C]", colour=colour_of(look.reading), kind="step", digits=2,
    )  # fmt: skip
    setpoint = curve(
        time, log["time_s"], log["setpoint_c"],
        name=f"{look.prefix}setpoint [°C]", colour=colour_of(look.setpoint), kind="step", digits=1,
    )  # fmt: skip
    yield setpoint | {"dashed": True}


def curve(  # noqa: PLR0913 - what a curve is made of
    time: TimeAxis,
    times_s: NDArray[np.generic],
    values: NDArray[np.generic],
    *,
    name: str,
    colour: str,
    kind: str,
    digits: int,
) -> Json:
    """Make a curve of no more points than a screen shows; `digits`: decimals of the read-out."""
    kept = thinned(values, MOST_POINTS)
    return {
        "name": name,
        "colour": colour,
        "kind": kind,
        "dashed": False,
        "digits": digits,
        "t": _short(time(times_s[kept].astype(np.float64)), 5),
        "v": _short(values[kept].astype(np.float64), 4),
    }


def _short(values: NDArray[np.float64], digits: int) -> list[float]:
    return [round(value, digits) for value in values.tolist()]


def _mark(time_s: float, text: str, time: TimeAxis, *, fault: bool) -> Json:
    return {"t": time_s / time.seconds, "text": text, "fault": fault}
