"""Error budgets of a spec's sensors on the ADC, as tables and as JSON."""

from collections.abc import Iterator
from typing import Any

from heatwright.spec import Controller, Problem, Spec
from heatwright.spec.quantity import about, celsius, number
from heatwright.spec.sensing.budget import Budget, budgets, judged


def show_budgets(controller: Controller) -> None:
    """Print the error that each part of a sensor's chain causes, over its range."""
    found_of = dict(budgets(controller))
    if not found_of:
        return
    from heatwright.cli.tables import heading, show, table  # noqa: PLC0415

    for name, found in found_of.items():
        heading(f"{name}: errors from its parts, ± {found.unit}")
        show(table(("part", "tolerance", *found.heads), found.rows, text_columns=2))
        if found.untold:
            heading(f"not given, and not counted: tolerances.{', '.join(found.untold)}")


def budgets_json(controller: Controller) -> dict[str, Any]:
    """Return the budgets as JSON data, by the sensors' names."""
    return {name: _json(found) for name, found in budgets(controller)}


def _json(found: Budget) -> dict[str, Any]:
    return {
        "unit": found.unit,
        "at": found.places,
        "parts": [line._asdict() for line in found.lines],
        "worst": found.worst,
        "root_of_squares": found.root,
        "not_told": found.untold,
    }


def too_inexact(spec: Spec) -> Iterator[Problem]:
    """Warn of sensors whose parts exceed the `accuracy`, or lack the tolerance to judge it."""
    controller = spec.controller
    for name, sensor in controller.sensors.items():
        asked = getattr(sensor, "accuracy", None)
        if asked is None:
            continue
        found, place = judged(sensor, controller.board.mcu)
        path = ("sensors", name, "accuracy")
        if found.worst[place] > asked.within_k:
            costly = max(found.lines, key=lambda line: line.errors[place])
            yield spec.tree.problem(
                path,
                f"in the {found.worst_case} the parts add {about(found.worst[place])} K at "
                f"{celsius(found.places[place])}, {about(found.root[place])} K as root of the sum "
                f"of squares, and at most {number(asked.within_k)} K is required",
                f"Use better parts (largest: {costly.part}, {about(costly.errors[place])} K), or "
                "calibrate the sensor",
            )
        elif found.untold:
            yield spec.tree.problem(
                path,
                f"it is unknown whether the error stays within {number(asked.within_k)} K",
                f"Write tolerances: {', '.join(found.untold)}",
            )
