"""Print the fabricator's published figures beside ours: its wire, its heating, its cooling.

The reference model, which the firmware equals bit for bit, is switched on at 300 °C, set to 30 °C
once the nozzle has been hot for long, and switched off.

    python tools/fabricator_figures.py spec/examples/fabricator.yaml
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import click
import numpy as np

from heatwright.cli.tables import show, table
from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.trace import Trace
from heatwright.spec import Controller, Event, PwmOutput, full_a, load

HEATER, LOOP, NODE, COLD_END = "heater", "nozzle", "block", "cold_end"
ON_S, MILD_S, END_S = 1.0, 1000.0, 1600.0
HOT_C, MILD_C, WAY_C, BAND_K = 300.0, 30.0, 250.0, 2.0
STARTED_S = 0.5
"""From then on the limit holds."""


class Figure(NamedTuple):
    """One figure; published -- as its author has it, or empty; residual -- ours less that."""

    what: str
    unit: str
    published: str
    ours: float
    residual: float | None
    digits: int


@click.command()
@click.argument("path", metavar="SPEC", type=click.Path(path_type=Path, exists=True))
def main(path: Path) -> None:
    """Run the machine of a spec and print its figures."""
    controller = load(path).controller
    rows = []
    for each in figures(controller, _run(controller)):
        residual = "" if each.residual is None else f"{each.residual:+.{each.digits}f}"
        ours = f"{each.ours:.{each.digits}f}"
        rows.append((f"{each.what} [{each.unit}]", each.published, ours, residual))
    show(table(("figure", "published", "ours", "residual"), rows))


def figures(controller: Controller, trace: Trace) -> Iterator[Figure]:
    """Yield the figures of a run."""
    heater = controller.outputs[HEATER]
    assert isinstance(heater, PwmOutput)  # noqa: S101 - else it has no such figures
    supply_v, peak_a = heater.supply_v or math.nan, full_a(heater) or math.nan
    times_s, mean_a = trace.times_s, trace.currents_a["current"]
    log = trace.steps[LOOP]
    on_s = float(log["time_s"][(log["duty_percent"] > 0).argmax()])
    held_a = mean_a[times_s >= on_s + STARTED_S].max()
    yield _near("resistance of the wire", "Ω", "8.54", supply_v / peak_a, 2)
    yield _near("most heat, half a second after it comes on", "W", "76.6", held_a * supply_v, 1)
    yield _near("its current, rms", "A", "3", math.sqrt(held_a * peak_a), 2)
    yield Figure("the same, mean", "A", "", held_a, None, 2)
    yield Figure("the same, while it is on", "A", "", peak_a, None, 2)
    block_c = trace.temperatures_c[NODE]
    way_s = float(times_s[(block_c >= WAY_C).argmax()]) - on_s
    yield _near("250 °C after", "s", "about 100", way_s, 1)
    readings_c, read_s = log["temperature_c"], log["time_s"]
    yield _first("300 °C, within 2 K, after", read_s, readings_c >= HOT_C - BAND_K, on_s)
    cold_end_k = trace.temperatures_c[COLD_END][times_s < MILD_S].max()
    over_k = float(cold_end_k) - _ambient_c(controller)
    yield Figure("cold end above its surroundings", "K", "20 … 40", over_k, None, 1)
    cool = (read_s > MILD_S) & (readings_c <= MILD_C + BAND_K)
    yield _first("30 °C, within 2 K, after", read_s, cool, MILD_S)


def _near(what: str, unit: str, published: str, ours: float, digits: int) -> Figure:
    residual = ours - float(published.rsplit(maxsplit=1)[-1])
    return Figure(what, unit, published, ours, round(residual, digits) + 0.0, digits)


def _first(what: str, times_s: np.ndarray, when: np.ndarray, from_s: float) -> Figure:
    return Figure(what, "s", "reached", float(times_s[when.argmax()]) - from_s, None, 1)


def _ambient_c(controller: Controller) -> float:
    return controller.simulated.ambient_c


def _run(controller: Controller) -> Trace:
    lines = (
        {"at": f"{ON_S} s", "write": {f"{LOOP}.setpoint": f"{HOT_C} °C", f"{LOOP}.enabled": True}},
        {"at": f"{MILD_S} s", "write": {f"{LOOP}.setpoint": f"{MILD_C} °C"}},
        {"for": f"{END_S} s"},
    )
    events = [Event.model_validate(line) for line in lines]
    return bench(controller, ReferenceDevice(controller), events)


if __name__ == "__main__":
    main()
