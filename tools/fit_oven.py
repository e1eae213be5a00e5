"""Fit the thermal network of spec/examples/oven.yaml to the published comparison.

Every row of the comparison is run in closed loop by the reference model; the figures that were
published (maximum and steady range of each row, and how far the temperature coasted up after
switch-off) are compared with ours. Differential evolution searches within physically sensible
bounds, a simplex finishes. Same seed, same result.

The heater's power stays as it is in the file. It cannot be found from temperatures alone: twice the
power, twice the capacities and half the resistances give the same curves.

    python tools/fit_oven.py spec/examples/oven.yaml --seed 1
    python tools/fit_oven.py spec/examples/oven.yaml --evaluate

One figure is doubtful: the published minimum of the proportional row. `--doubt` leaves it out of
the fit, or takes it for the lowest reading after the first maximum; `--from-file` begins where the
file's plant is, with the simplex alone.

    python tools/fit_oven.py spec/examples/oven.yaml --doubt dip --evaluate --json -
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from operator import itemgetter
from pathlib import Path
from statistics import fmean
from typing import Any, NamedTuple, TextIO

import click
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import Progress
from rich.table import Table
from scipy.optimize import Bounds, differential_evolution, minimize

from heatwright.sim.comparison import run_row
from heatwright.sim.faults.healthy import scaled as scaled_network
from heatwright.sim.judges.metrics import metrics
from heatwright.sim.trace import StepLog
from heatwright.spec import ComparisonRow, Controller, Event, ThermalNetwork, load, row_controller

COAST_UP_K = 1.5
"""Published rise after switch-off, "about"; seen in the first heating of the plain threshold."""

SIMPLEX_EVALUATIONS = 600

DOUBTFUL = ("proportional", "steady minimum")
"""Row and figure: under a constant load pure proportional control rests within a sensor step."""
DOUBTS = ("keep", "leave-out", "dip")

HALF_DIGIT_K = 0.05
"""Half of the last digit of the published figures: equal temperatures may differ by this and half a
step of the sensor."""
OURS, SETPOINTS_C, OFF_BY = "heatwright", (50.0, 40.0, 60.0, 70.0), (0.7, 1.0, 1.3)
"""Our rows, and by how much all capacities and all resistances are off. With the least resistances
the heater holds no more than 66 °C: they are tried at the first setpoint alone."""

Point = NDArray[np.float64]


class Parameter(NamedTuple):
    """A free parameter, searched on a logarithmic scale unless it is a temperature."""

    name: str
    unit: str
    low: float
    high: float
    why: str

    @property
    def logarithmic(self) -> bool:
        """Whether ratios matter rather than differences."""
        return self.unit != "°C"


PARAMETERS = (
    Parameter("rise", "K", 50, 75, "above ambient at full power; 70 °C was held, 50 °C took half"),
    Parameter("element_over", "K", 20, 300, "element above the air at full power"),
    Parameter("walls_share", "1", 0.1, 0.9, "of the rise that falls between walls and ambient"),
    Parameter("element", "J/K", 5, 500, "a wire at least, a finned body at most"),
    Parameter("air", "J/K", 30, 3000, "some litres of air and what is thin"),
    Parameter("walls", "J/K", 300, 20000, "kilograms of metal or insulation"),
    Parameter("lag", "s", 1, 40, "DS18B20 in moving to still air"),
    Parameter("delay", "s", 0.05, 20, "transport of the air"),
    Parameter("ambient", "°C", 18, 28, "a laboratory"),
)


@dataclass(frozen=True)
class Figure:
    """One published figure and ours."""

    row: str
    name: str
    published: float
    found: float
    counts: bool = True
    """Whether the fit goes by it."""

    @property
    def error(self) -> float:
        """Ours minus the published one, K."""
        return self.found - self.published


def values_of(point: Point) -> dict[str, float]:
    """Return the physical values of a point of the search space."""
    return {
        parameter.name: math.exp(x) if parameter.logarithmic else float(x)
        for parameter, x in zip(PARAMETERS, point, strict=True)
    }


def search_bounds() -> Bounds[tuple[int], np.float64]:
    """Return the bounds of the search space."""
    ends = [
        (math.log(p.low), math.log(p.high)) if p.logarithmic else (p.low, p.high)
        for p in PARAMETERS
    ]
    low, high = np.array(ends).T
    return Bounds(low, high)


def oven_with(controller: Controller, values: dict[str, float]) -> Controller:
    """Return the controller with a plant of these values."""
    simulation = controller.simulation
    if simulation is None:
        raise click.UsageError("the specification has no `simulation`")
    ((output, _),) = simulation.plant.heat.items()
    power_w = controller.outputs[output].power_w or 0.0
    plant = simulation.plant.model_copy(update=plant_update(simulation.plant, values, power_w))
    changed = simulation.model_copy(update={"plant": plant, "ambient_c": values["ambient"]})
    return controller.model_copy(update={"simulation": changed})


def plant_update(
    plant: ThermalNetwork, values: dict[str, float], power_w: float
) -> dict[str, object]:
    """Return the fields of the network that the fit changes."""
    outer = values["rise"] * values["walls_share"] / power_w
    resistances = (
        values["element_over"] / power_w,
        values["rise"] / power_w - outer,
        outer,
    )
    ((sensor, sense),) = plant.sense.items()
    return {
        "nodes": {name: values[name] for name in ("element", "air", "walls")},
        "links": tuple(
            link.model_copy(update={"resistance_k_per_w": resistance})
            for link, resistance in zip(plant.links, resistances, strict=True)
        ),
        "sense": {
            sensor: sense.model_copy(update={"lag_s": values["lag"], "delay_s": values["delay"]})
        },
    }


def coast_up(log: StepLog) -> float:
    """Return how far the reading rose after the heater was first switched off, K."""
    on = log["duty_percent"] > 0
    off = int(np.flatnonzero(on[:-1] & ~on[1:])[0]) + 1 if on.any() and not on.all() else -1
    return float(log["temperature_c"][off:].max() - log["temperature_c"][off])


def dip_c(log: StepLog) -> float:
    """Return the lowest reading after the first maximum, °C."""
    readings = log["temperature_c"][log["has_reading"] != 0]
    return float(readings[int(readings.argmax()) :].min())


def figures_of(controller: Controller, row: ComparisonRow, doubt: str = "keep") -> Iterator[Figure]:
    """Run a row and yield its figures; `doubt`, of DOUBTS, says what the doubtful one is."""
    published = row.published
    if published is None:
        return
    trace = run_row(controller, row)
    found = metrics(trace, row_controller(controller, row))
    label = f"{row.name}, {row.setpoint_c:g} °C"
    yield Figure(label, "maximum", published.maximum_c, found.maximum_c)
    minimum_c, counts = found.steady_minimum_c, True
    if (row.name, "steady minimum") == DOUBTFUL:
        (log,) = trace.steps.values()
        minimum_c, counts = dip_c(log) if doubt == "dip" else minimum_c, doubt != "leave-out"
    yield Figure(label, "steady minimum", published.steady_minimum_c, minimum_c, counts)
    yield Figure(label, "steady maximum", published.steady_maximum_c, found.steady_maximum_c)
    algorithm = row.algorithm
    if algorithm.kind == "on_off" and not (algorithm.hysteresis_k or algorithm.lead_s):
        (log,) = trace.steps.values()
        yield Figure(label, "coast-up", COAST_UP_K, coast_up(log))


def all_figures(controller: Controller, doubt: str = "keep") -> list[Figure]:
    """Run every published row."""
    return [
        figure for row in controller.comparison for figure in figures_of(controller, row, doubt)
    ]


def squares(controller: Controller, point: Point, doubt: str = "keep") -> float:
    """Return the sum of the squared errors at a point of the search space, K²."""
    bounds = search_bounds()
    inside = np.clip(point, bounds.lb, bounds.ub)
    outside = float(((point - inside) ** 2).sum())
    found = all_figures(oven_with(controller, values_of(inside)), doubt)
    return sum(figure.error**2 for figure in found if figure.counts) + outside


def search(  # noqa: PLR0913 – all but one have names
    controller: Controller,
    *,
    seed: int,
    generations: int,
    workers: int,
    report: Callable[[], None],
    simplex: int = SIMPLEX_EVALUATIONS,
    doubt: str = "keep",
) -> Point:
    """Find the best point; `simplex` limits the evaluations of the finish."""
    goal = partial(squares, controller, doubt=doubt)
    coarse = differential_evolution(
        goal,
        search_bounds(),
        popsize=6,
        maxiter=generations,
        rng=seed,
        polish=False,
        updating="deferred",
        workers=workers,
        callback=lambda *_, **__: report(),
    )
    fine = refined(controller, coarse.x, simplex, doubt)
    return fine if squares(controller, fine, doubt) < coarse.fun else coarse.x


def refined(controller: Controller, point: Point, simplex: int, doubt: str) -> Point:
    """Go downhill from a point, by so many evaluations at most."""
    fine = minimize(
        partial(squares, controller, doubt=doubt),
        point,
        method="Nelder-Mead",
        options={"maxfev": simplex, "initial_simplex": simplex_around(point), "adaptive": True},
    )
    bounds = search_bounds()
    return np.clip(fine.x, bounds.lb, bounds.ub)


def point_of(values: dict[str, float]) -> Point:
    """Return the point of the search space that has these physical values."""
    return np.array(
        [math.log(values[p.name]) if p.logarithmic else values[p.name] for p in PARAMETERS]
    )


def simplex_around(point: Point) -> NDArray[np.float64]:
    """Return a simplex of 5 % steps: smaller ones drown in the sensor's steps."""
    return np.vstack([point, *(point + 0.05 * unit for unit in np.eye(len(point)))])


def shortened(controller: Controller, duration_s: float) -> Controller:
    """Return the controller with a shorter scenario."""
    if controller.simulation is None:
        raise click.UsageError("the specification has no `simulation`")
    scenario = (Event.model_validate({"for": f"{duration_s:g} s"}),)
    simulation = controller.simulation.model_copy(update={"scenario": scenario})
    return controller.model_copy(update={"simulation": simulation})


def spread_of(controller: Controller) -> Iterator[tuple[str, float]]:
    """Run our rows on machines that are off; yield which, and the largest overshoot or error, K."""
    simulation = controller.simulated
    rows = {row.setpoint_c: row for row in controller.comparison if row.name == OURS}
    for setpoint_c, capacity, resistance in product(SETPOINTS_C, OFF_BY, OFF_BY):
        if setpoint_c != SETPOINTS_C[0] and resistance == min(OFF_BY):
            continue
        row = rows[setpoint_c]
        plant = scaled_network(simulation.plant, capacity, resistance)
        found = metrics(run_row(controller, row, plant=plant), row_controller(controller, row))
        what = f"{setpoint_c:g} °C, capacities × {capacity:g}, resistances × {resistance:g}"
        yield what, max(found.overshoot_k, found.steady_error_k)


def show_spread(console: Console, controller: Controller) -> None:
    """Print in how many cases our rows keep within a step of the sensor, and the worst."""
    found = list(spread_of(controller))
    step_k = step_of(controller)
    within = sum(most_k <= step_k for _, most_k in found)
    what, most_k = max(found, key=itemgetter(1))
    console.print(f"ours within {step_k:g} K in {within} of {len(found)} cases")
    console.print(f"ours at most {most_k:.2f} K off ({what})")


def step_of(controller: Controller) -> float:
    """Return the sensor's step, K."""
    sensor: Any = controller.sensors[next(iter(controller.loops.values())).sensor]
    return float(sensor.step_k)


def show(
    console: Console, values: dict[str, float], figures: list[Figure], sensor_step_k: float
) -> None:
    """Print the values and how well they fit."""
    table = Table("parameter", "value", "unit", "bounds", "what")
    for parameter in PARAMETERS:
        bounds = f"{parameter.low:g} .. {parameter.high:g}"
        value = f"{values[parameter.name]:.4g}"
        table.add_row(parameter.name, value, parameter.unit, bounds, parameter.why)
    console.print(table)
    table = Table("row", "figure", "published °C", "ours °C", "error K")
    for figure in figures:
        numbers = (f"{figure.published:.2f}", f"{figure.found:.2f}", f"{figure.error:+.2f}")
        table.add_row(figure.row, figure.name, *numbers)
    console.print(table)
    worst = max((each for each in figures if each.counts), key=lambda figure: abs(figure.error))
    console.print(
        f"rms {rms(figures):.3f} K, worst {worst.error:+.3f} K ({worst.row}, {worst.name})"
    )
    for what, bound_k in (
        ("half a step of the sensor and half a digit", sensor_step_k / 2 + HALF_DIGIT_K),
        ("two steps of the sensor", 2 * sensor_step_k),
    ):
        near = sum(abs(figure.error) <= bound_k for figure in figures)
        console.print(f"within {what} ({bound_k:.2f} K): {near} of {len(figures)}")


def rms(figures: list[Figure]) -> float:
    """Return the root of the mean squared error of those that count, K."""
    return math.sqrt(fmean(figure.error**2 for figure in figures if figure.counts))


def as_json(values: dict[str, float], figures: list[Figure]) -> str:
    """Return the values, all figures and how well they fit, for machines."""
    told = [{**asdict(figure), "error": figure.error} for figure in figures]
    return json.dumps({**values, "rms": rms(figures), "figures": told}, indent=2) + "\n"


@click.command()
@click.argument("spec", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--seed", default=1, show_default=True, help="Seed of the search.")
@click.option("--generations", default=25, show_default=True, help="Generations, at most.")
@click.option("--workers", default=1, show_default=True, help="Processes.")
@click.option("--minutes", default=30.0, show_default=True, help="Simulated time of each row.")
@click.option("--evaluate", is_flag=True, help="Only show how well the file's own plant fits.")
@click.option("--doubt", type=click.Choice(DOUBTS), default="keep", help="The doubtful figure.")
@click.option("--values", "given", default="", help="NAME=VALUE,…: in the place of the file's.")
@click.option("--from-file", is_flag=True, help="Begin at the file's plant, simplex alone.")
@click.option("--simplex", default=SIMPLEX_EVALUATIONS, show_default=True, help="Evaluations.")
@click.option("--spread", is_flag=True, help="Run our rows on machines that are off, too.")
@click.option("--json", "output", type=click.File("w"), help="Write values and figures; - prints.")
def main(  # noqa: PLR0913, PLR0917 – one for each option
    spec: Path,
    seed: int,
    generations: int,
    workers: int,
    minutes: float,
    evaluate: bool,
    doubt: str,
    given: str,
    from_file: bool,
    simplex: int,
    spread: bool,
    output: TextIO | None,
) -> None:
    """Fit the oven's plant to the published figures of its comparison rows."""
    console = Console(stderr=output is not None)
    controller = load(spec).controller
    short = shortened(controller, minutes * 60)
    values = values_of_file(controller) | values_given(given)
    if from_file and not evaluate:
        values = values_of(refined(short, point_of(values), simplex, doubt))
    elif not evaluate:
        with Progress(console=console) as progress:
            task = progress.add_task("searching", total=generations)
            values = values_of(
                search(
                    short, seed=seed, generations=generations, workers=workers,
                    report=lambda: progress.advance(task), simplex=simplex, doubt=doubt,
                )
            )  # fmt: skip
    figures = all_figures(oven_with(controller, values), doubt)
    show(console, values, figures, step_of(controller))
    if spread:
        show_spread(console, oven_with(controller, values))
    if output is not None:
        output.write(as_json(values, figures))


def values_given(text: str) -> dict[str, float]:
    """Read `rise=60,lag=20`. Raises UsageError: a name is none of PARAMETERS."""
    found: dict[str, float] = {}
    for part in filter(None, text.split(",")):
        name, _, value = part.partition("=")
        if name not in {parameter.name for parameter in PARAMETERS}:
            raise click.UsageError(f"--values: there is no parameter {name!r}")
        found[name] = float(value)
    return found


def values_of_file(controller: Controller) -> dict[str, float]:
    """Return the fit's parameters of the file's own plant."""
    simulation = controller.simulation
    if simulation is None:
        raise click.UsageError("the specification has no `simulation`")
    ((output, _),) = simulation.plant.heat.items()
    power_w = controller.outputs[output].power_w or 0.0
    over, inner, outer = (link.resistance_k_per_w * power_w for link in simulation.plant.links)
    ((_, sense),) = simulation.plant.sense.items()
    return {
        "rise": inner + outer,
        "element_over": over,
        "walls_share": outer / (inner + outer),
        **simulation.plant.nodes,
        "lag": sense.lag_s,
        "delay": sense.delay_s,
        "ambient": simulation.ambient_c,
    }


if __name__ == "__main__":
    main()
