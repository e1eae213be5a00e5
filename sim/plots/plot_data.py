"""Shared by all plots of a run: colours, axes, faults, thinning of points."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle, pairwise

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.judges.metrics import response_of
from heatwright.sim.plants import nodes_of
from heatwright.sim.reference.programs.state import RUNNING
from heatwright.sim.scenario import PRESS_S
from heatwright.sim.trace import Series, StepLog, Trace, TraceEvent
from heatwright.spec import RULES, Controller, Loop

NODES = ("#e69f00", "#009e73", "#56b4e9", "#cc79a7", "#b0a000", "#7f7f7f")
READING = "#0050a0"
SETPOINT = "#202020"
HEAT = "#d55e00"
COOL = "#56b4e9"
FAULT = "#c00000"
SHARED = "#909090"
LOOPS = (READING, "#d55e00", "#009e73", "#cc79a7", "#b0a000", "#56b4e9")
"""Colours that colour-blind people can distinguish (Okabe & Ito, Color Universal Design, 2008).

LOOPS are the colours of several loops, one for all curves of a loop."""

LEAST_ZOOM_K = 0.5
"""Half of the smallest height of the zoom: eight steps of a 12-bit sensor."""

USUAL_SHARE = 0.95
"""Share of a program's deviations that must fit into their plot."""

LEAST_BAND_K = 1.0
"""Half of the smallest height of the plot of a program's deviations."""

SEEN_SHARE = 0.05
"""Smallest visible part of a plot, as a share of its height."""

ROOM = 1.15
"""Height of the zoom over the height of its curve."""

TIME_UNITS = (("h", 3600.0, 3 * 3600.0), ("min", 60.0, 300.0), ("s", 1.0, 0.0))
"""Units of the time axis: name, seconds, and the shortest length of a run that uses it, s."""

Tripped = tuple[float, int]
"""Time (s) and code of a fault."""


@dataclass(frozen=True)
class Look:
    """Colours of a loop's curves, and the prefix of their names."""

    reading: str = READING
    setpoint: str = SETPOINT
    heat: str = HEAT
    cool: str = COOL
    prefix: str = ""


def looks_of(loops: Iterable[str]) -> dict[str, Look]:
    """Choose the colours: one for each of several loops, or one for each curve of a single loop."""
    names = tuple(loops)
    if len(names) == 1:
        return {names[0]: Look()}
    return {
        name: Look(colour, colour, colour, COOL, f"{name} ")
        for name, colour in zip(names, cycle(LOOPS), strict=False)
    }


def node_colours(
    controller: Controller, nodes: Iterable[str], looks: Mapping[str, Look]
) -> dict[str, str]:
    """Choose a colour for each node.

    With several loops it is that of the node's loop; grey if it belongs to none or to several.
    """
    if len(looks) == 1 or controller.simulation is None:
        return dict(zip(nodes, cycle(NODES), strict=False))
    own = nodes_of(controller, controller.simulation.plant)
    owners = {node: [name for name in own if node in own[name]] for node in nodes}
    return {
        node: looks[names[0]].reading if len(names) == 1 else SHARED
        for node, names in owners.items()
    }


@dataclass(frozen=True)
class TimeAxis:
    """Converts seconds to the unit of the axis."""

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


def all_faults(trace: Trace) -> tuple[Tripped, ...]:
    """Return when faults tripped in a run, and their codes.

    There is one latch: all loops see a fault, each with its next step.
    """
    found: list[Tripped] = []
    seen = sorted(
        (time_s, code, float(np.diff(log["time_s"]).max(initial=0.0)))
        for log in trace.steps.values()
        for time_s, code in faults(log)
    )
    for time_s, code, gap_s in seen:
        if not any(code == other and time_s - first_s <= gap_s for first_s, other in found):
            found.append((time_s, code))
    return tuple(found)


def key_presses(trace: Trace) -> list[tuple[float, str]]:
    """Return the operator's actions with their times; repeated presses are joined: `up ×3`."""
    groups: list[list[TraceEvent]] = []
    for event in trace.events:
        at_once = groups and event.time_s - groups[-1][-1].time_s < 3 * PRESS_S
        if at_once and event.text == groups[-1][-1].text:
            groups[-1].append(event)
        else:
            groups.append([event])
    found: list[tuple[float, str]] = []
    for group in groups:
        time_s = group[0].time_s
        text = group[0].text + (f" ×{len(group)}" if len(group) > 1 else "")
        if found and found[-1][0] == time_s:
            found[-1] = (time_s, f"{found[-1][1]}, {text}")
        else:
            found.append((time_s, text))
    return found


def label_rows(
    labels: Sequence[tuple[float, str]], span_s: float, letters: int
) -> list[tuple[int, bool]]:
    """Choose a row for each label so that none overlap, and whether it stands before its line.

    letters -- number that fits across the span; a label that would go beyond the span's end stands
    before its line.
    """
    rows: list[list[tuple[float, float]]] = []
    found = []
    for time_s, text in labels:
        long_s = (len(text) + 1) * span_s / letters
        late = time_s + long_s > span_s
        start_s = time_s - long_s if late else time_s
        end_s = start_s + long_s
        row = next(
            (row for row, taken in enumerate(rows)
             if all(end_s <= start or end <= start_s for start, end in taken)),
            len(rows),
        )  # fmt: skip
        rows += [[]] if row == len(rows) else []
        rows[row].append((start_s, end_s))
        found.append((row, late))
    return found


def asked_of(log: StepLog, loop: Loop, look: Look) -> dict[str, tuple[Series, str]]:
    """Return the duty of heater and cooler at each step, %, and their colours."""
    asked: dict[str, tuple[Series, str]] = {loop.heater: (log["duty_percent"], look.heat)}
    if loop.cooler is not None:
        asked[loop.cooler] = (100.0 * log["cooling"], look.cool)
    return asked


def fault_label(code: int) -> str:
    """Return a fault's text as on the display."""
    return f"E{code:02d} {RULES[code].display}"


def with_reading(log: StepLog) -> StepLog:
    """Return the steps from the first reading on."""
    seen: StepLog = log[log["has_reading"] != 0]
    return seen


def closer(log: StepLog) -> tuple[float, float]:
    """Choose the range of the zoom, °C: the readings after they first reached the setpoint."""
    response = with_reading(response_of(log))
    if not len(response):
        setpoint_c = float(log["setpoint_c"][-1])
        return setpoint_c - LEAST_ZOOM_K, setpoint_c + LEAST_ZOOM_K
    return zoom(response["temperature_c"].astype(float), float(response["setpoint_c"][-1]))


def eventful_s(log: StepLog) -> float:
    """Return the time after which a run behaves as in its last third, s."""
    readings_c, times_s = log["temperature_c"].astype(float), log["time_s"].astype(float)
    rest_c = readings_c[2 * len(log) // 3 :]
    room_k = SEEN_SHARE * float(np.ptp(readings_c))
    outside = (readings_c < rest_c.min() - room_k) | (readings_c > rest_c.max() + room_k)
    return float(times_s[outside][-1]) if outside.any() else float(times_s[-1])


def zoom(readings_c: Series, setpoint_c: float) -> tuple[float, float]:
    """Choose a range around the setpoint that contains the readings after they first reached it."""
    errors_k = readings_c - setpoint_c
    met = np.flatnonzero(np.diff(np.sign(errors_k)) != 0)
    start = int(met[0]) if len(met) else 2 * len(errors_k) // 3
    half_k = max(LEAST_ZOOM_K, ROOM * float(np.abs(errors_k[start:]).max(initial=0.0)))
    return setpoint_c - half_k, setpoint_c + half_k


def runs_program(log: StepLog) -> bool:
    """Return whether a program has set the setpoint."""
    return "program.state" in (log.dtype.names or ()) and bool(
        (log["program.state"] == RUNNING).any()
    )


def followed(log: StepLog) -> StepLog:
    """Return the steps with a reading in which a program runs."""
    running: StepLog = log[(log["program.state"] == RUNNING) & (log["has_reading"] != 0)]
    return running


def deviation_k(log: StepLog) -> Series:
    """Return how far the readings are above the setpoint, K."""
    deviations: Series = log["temperature_c"].astype(float) - log["setpoint_c"].astype(float)
    return deviations


def band_k(log: StepLog) -> tuple[float, float]:
    """Choose the range of a program's deviations: symmetric, with all but a twentieth of them.

    Otherwise the large deviations of a machine that cools too slowly would hide the others.
    """
    half_k = ROOM * float(np.quantile(np.abs(deviation_k(followed(log))), USUAL_SHARE))
    half_k = max(LEAST_BAND_K, half_k)
    return -half_k, half_k


def thinned(values: NDArray[np.generic], most: int) -> NDArray[np.intp]:
    """Choose rows that draw the same curve: first, last, lowest and highest of each slice.

    (Jugel et al., M4: A Visualization-Oriented Time Series Data Aggregation, VLDB 2014.)
    """
    count = len(values)
    if count <= most:
        return np.arange(count)
    edges = np.linspace(0, count, most // 4 + 1).astype(int)
    kept: set[int] = set()
    for start, end in pairwise(edges.tolist()):
        part = values[start:end]
        kept |= {start, end - 1, start + int(part.argmin()), start + int(part.argmax())}
    return np.array(sorted(kept))
