"""The checks that compare several entries of a spec: references, pins, timers, physics."""

from collections.abc import Iterator
from importlib import import_module
from pkgutil import walk_packages

from heatwright.spec.adjusted import extremes, with_setting
from heatwright.spec.checks import references
from heatwright.spec.checks.comparison import row_controller, row_path, rows_have_loops
from heatwright.spec.checks.finding import Check, Finding, Findings, PlantCheck
from heatwright.spec.checks.loops import adjusted, monitors, three_position
from heatwright.spec.checks.physics import plant
from heatwright.spec.checks.physics.thermal import thermal
from heatwright.spec.controller import Controller


def _checks() -> Iterator[Check]:
    """Find the checks of all modules here: public functions from a controller to findings."""
    annotations = {"controller": Controller, "return": Findings}
    for found in walk_packages(__path__, f"{__name__}."):
        for name, value in vars(import_module(found.name)).items():
            if not name.startswith("_") and getattr(value, "__annotations__", None) == annotations:
                yield value


CHECKS: tuple[Check, ...] = tuple(
    dict.fromkeys(_checks())
)  # each once: some modules import others' checks

# These checks use the whole plant, so they run only if all names in the plant are defined.
SIMULATION_CHECKS: tuple[PlantCheck, ...] = (
    plant.plant_links,
    plant.plant_radiation,
    plant.plant_nodes,
    plant.plant_covers_loops,
    monitors.plant_covers_monitors,
    plant.senses_fit,
    plant.currents_are_sensed,
    plant.heat_arrives,
    three_position.coolers_cool,
)


def check(controller: Controller) -> list[Finding]:
    """Run all checks on a controller.

    The extremes of numbers that the keypad can set, and the rows of a comparison, add only findings
    that the controller itself does not have.
    """
    simulation = controller.simulation
    found: list[Finding] = []
    if simulation is not None:
        found += plant.plant_names(controller, simulation.plant)
        for each in SIMULATION_CHECKS if not found else ():
            found += each(controller, simulation.plant)
    whole = not found and not [*references.loop_parts(controller)]
    found += _check_one(controller, whole)
    own = {finding[:3] for finding in found}
    found += _of_extremes(controller, whole, {*own})
    lost = {finding.path[1] for finding in rows_have_loops(controller)}
    for index, row in enumerate(controller.comparison):
        if index in lost:
            continue
        for finding in _check_one(row_controller(controller, row), whole, any_setpoint=False):
            if finding[:3] not in own:
                path = row_path(controller, index, finding.path)
                found.append(finding._replace(path=path))
    return found


def _of_extremes(
    controller: Controller, whole: bool, known: set[tuple[object, ...]]
) -> list[Finding]:
    """Check the controller at the extremes of the numbers that the keypad can set."""
    if [*adjusted.numbers_have_a_use(controller), *adjusted.numbers_in_range(controller)]:
        return []
    found = []
    for setting in extremes(controller):
        for finding in _check_one(with_setting(controller, setting), whole):
            if finding[:3] not in known:
                known.add(finding[:3])
                found.append(adjusted.of_extreme(controller, finding, setting))
    return found


def _check_one(controller: Controller, whole: bool, *, any_setpoint: bool = True) -> list[Finding]:
    """Run the checks of one controller; of physics only if all parts of its machine are valid."""
    found = [finding for each in CHECKS for finding in each(controller)]
    if whole:
        found += thermal(controller, any_setpoint=any_setpoint)
        if controller.simulation is not None:
            found += monitors.monitors_hold(controller, controller.simulation)
    return found
