# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

WIDTH_IN, HEIGHT_IN = 10, 8
STYLE: dict[Any, Any] = {
    "font.size": 9,
    "svg.hashsalt": "benchmarks",
    "svg.fonttype": "none",
    "axes.spines.top": False,
    "axes.spines.right": False,
}


def draw(found: dict[str, Any], path: Path) -> None:
    """Draw what was measured: the same figures give the same bytes."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN), layout="constrained")
        axes = figure.subplots(2, 2).flat
        for part, axis in zip((startup, verify, cores, growth), axes, strict=True):
            if part.__name__ in found:
                part(found[part.__name__], axis)
            else:
                axis.set_axis_off()
        metadata = {"Date": None} if path.suffix == ".svg" else None
        figure.savefig(path, metadata=metadata)


def startup(found: dict[str, Any], axis: Axes) -> None:
    """Bars of commands that only read and write."""
    yard = found["yard_s"]
    ours = {name: took for name, took in found["ours"].items() if name != "check"}
    theirs = {f"esphome {name}": took for name, took in found["esphome"].items()}
    both = ours | theirs
    colours = ["C0"] * len(ours) + ["0.6"] * len(theirs)
    axis.barh(list(both), [took / yard for took in both.values()], color=colours)
    axis.invert_yaxis()
    axis.set(title="Start-up", xlabel="yards")


def verify(found: dict[str, Any], axis: Axes) -> None:
    """Bars of `verify`."""
    yards = [each["processor_s"] / each["yard_s"] for each in found.values()]
    axis.barh([f"{name}, {each['faults']} faults" for name, each in found.items()], yards)
    axis.invert_yaxis()
    axis.set(title="verify", xlabel="yards")


def cores(found: dict[str, Any], axis: Axes) -> None:
    """Groups of bars: each program on each simulator."""
    names = list(dict.fromkeys(name for each in found.values() for name in each))
    height = 0.8 / len(names)
    for number, name in enumerate(names):
        places = [place + (number + 0.5) * height - 0.4 for place in range(len(found))]
        axis.barh(places, [each.get(name, 0) for each in found.values()], height, label=name)
    axis.set_yticks(range(len(found)), list(found))
    axis.invert_yaxis()
    axis.set(title="The processor alone", xlabel="times real time", xscale="log", xlim=(1, None))
    axis.legend(frameon=False, ncols=2, loc="upper center", bbox_to_anchor=(0.3, -0.15))


def growth(found: dict[str, Any], axis: Axes) -> None:
    """Lines: time against how many, both in multiples of the first."""
    loops, length = found["loops"], found["length"]
    lines = {
        "verify: faults": [(each["faults"], each["verify_s"]) for each in loops],
        "simulate: loops": [(each["loops"], each["simulate_s"]) for each in loops],
        "simulate: hours": [(each["hours"], each["simulate_s"]) for each in length],
    }
    for name, points in lines.items():
        first = points[0]
        axis.plot(*zip(*((x / first[0], y / first[1]) for x, y in points), strict=True),
                  marker="o", label=name)  # fmt: skip
    ends = (1, max(axis.get_xlim()[1], 1))
    axis.plot(ends, ends, color="0.8", zorder=0, label="in proportion")
    axis.set(title="Growth", xlabel="times as much", ylabel="times as long")
    for each, scale in ((axis.xaxis, axis.set_xscale), (axis.yaxis, axis.set_yscale)):
        scale("log")
        each.set_major_locator(LogLocator(subs=(1, 2, 5)))
        each.set_major_formatter("{x:g}")
        each.set_minor_formatter("")
    axis.legend(frameon=False)
