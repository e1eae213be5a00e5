"""Print how the published law of the feeder swings: by its weights, the sensor's lag, the period.

Published are its counts for each kelvin and the limit of its sum; not told are the weights of sum
and difference in a step, nor the machine. Each line runs the law at three setpoints with the
reference model, which the firmware equals bit for bit, and tells how far the steady readings go
from the setpoint. The last two are, of all weights that are tried, those that keep nearest to the
published band. Below them stands what the parts cost, with either feed of the bridge.

    python tools/feeder_figures.py spec/examples/feeder.yaml
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import click

from heatwright.cli.tables import show, table
from heatwright.sim.comparison import run_row
from heatwright.sim.judges.metrics import metrics
from heatwright.spec import ComparisonRow, Controller, Pid, load, row_controller
from heatwright.spec.sensing.budget import judged

LOOP, SENSOR = "nozzle", "nozzle"
FULL, MOST_SUM_K = 5995, 900
"""Counts of full duty; the sum's limit."""
PUBLISHED_K = -0.8, 0.9
SUMS, DIFFERENCES = (3, 4, 5), (0, 250, 500, 1000, 4000, 8500, 12_000, 17_000)
"""Counts for each kelvin of sum and of difference, which the search combines."""


class Law(NamedTuple):
    """The published law with what is not told of it; counts for each kelvin."""

    of_sum: int = 4
    of_difference: int = 2000
    lag_s: float = 3.0
    period_s: float = 0.25


Swing = tuple[float, float]
"""Least and most of the steady readings, less the setpoint, K."""

TOLD = (
    Law(),
    Law(of_difference=0),
    Law(of_difference=5000),
    Law(of_difference=8500),
    Law(period_s=1.0),
    Law(period_s=2.0),
    Law(lag_s=0.5),
)


@click.command()
@click.argument("path", metavar="SPEC", type=click.Path(path_type=Path, exists=True))
def main(path: Path) -> None:
    """Print the swing of the laws that are told of, and of the best."""
    controller = load(path).controller
    rows = [row for row in controller.comparison if row.name == controller.comparison[0].name]
    setpoints = (f"{row.setpoint_c:g} °C" for row in rows)
    head = ("sum", "difference", "lag [s]", "period [s]", *setpoints, "beyond the band [K]")
    lines = [(law, swings(controller, rows, law)) for law in (*TOLD, *bests(controller, rows))]
    show(table(head, [written(*each) for each in lines]))
    show(table(("feed of the bridge", "worst case [K]", "root of squares [K]"), parts(controller)))


def parts(controller: Controller) -> Iterator[tuple[str, str, str]]:
    """Yield what the parts cost where that is most, with the spec's feed and the reference's."""
    sensor: Any = controller.sensors[SENSOR]
    fed = sensor.tolerances.model_copy(update={"supply_v": "reference"})
    for feed, each in (
        ("a supply of its own", sensor),
        ("the reference", sensor.model_copy(update={"tolerances": fed})),
    ):
        found, place = judged(each, controller.board.mcu)
        yield feed, f"{found.worst[place]:.2f}", f"{found.root[place]:.2f}"


def bests(controller: Controller, rows: list[ComparisonRow]) -> Iterator[Law]:
    """Yield the weights with which the law leaves the published band least, for either lag."""
    for lag_s in (3.0, 0.5):
        laws = [Law(*weights, lag_s) for weights in product(SUMS, DIFFERENCES)]
        yield min(laws, key=lambda law: beyond_k(swings(controller, rows, law)))


def beyond_k(found: list[Swing]) -> float:
    """Return how far the worst of swings leaves the published band, K; not below 0."""
    least_k, most_k = PUBLISHED_K
    return max(0.0, *(max(least_k - low, high - most_k) for low, high in found))


def swings(controller: Controller, rows: list[ComparisonRow], law: Law) -> list[Swing]:
    """Run the rows with a law."""
    found = []
    for row in rows:
        changed, varied = with_law(controller, law), row_with(row, law)
        figures = metrics(run_row(changed, varied), row_controller(changed, varied))
        found.append(
            (figures.steady_minimum_c - row.setpoint_c, figures.steady_maximum_c - row.setpoint_c)
        )
    return found


def with_law(controller: Controller, law: Law) -> Controller:
    """Return the controller with a law's period, and its machine with the lag."""
    simulation = controller.simulated
    sense = {**simulation.plant.sense}
    sense[SENSOR] = sense[SENSOR].model_copy(update={"lag_s": law.lag_s})
    plant = simulation.plant.model_copy(update={"sense": sense})
    machine = simulation.model_copy(update={"plant": plant})
    loop = controller.loops[LOOP].model_copy(update={"period_s": law.period_s})
    return controller.with_loop(LOOP, loop).model_copy(update={"simulation": machine})


def row_with(row: ComparisonRow, law: Law) -> ComparisonRow:
    """Return a row of the published law with other weights."""
    pid = row.algorithm
    assert isinstance(pid, Pid)  # noqa: S101 - the published law is one
    percent = 100 / FULL
    ends = {
        f"{end}_percent": sign * MOST_SUM_K * law.of_sum * percent
        for end, sign in (("minimum", -1), ("maximum", 1))
    }
    gains = {
        "ki": law.of_sum * percent / law.period_s,
        "kd": law.of_difference * percent * law.period_s,
        "integral": pid.integral.model_copy(update=ends),
    }
    return row.model_copy(update={"algorithm": pid.model_copy(update=gains)})


def written(law: Law, found: list[Swing]) -> tuple[str, ...]:
    """Write a line of the table."""
    return (
        *(f"{each:g}" for each in law),
        *(f"{low:+.2f} … {high:+.2f}" for low, high in found),
        f"{beyond_k(found):.2f}",
    )


if __name__ == "__main__":
    main()
