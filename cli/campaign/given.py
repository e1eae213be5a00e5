"""The variations of a campaign: read from a file and checked against the spec, or derived."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from heatwright.cli.beside import machine_of, read_beside
from heatwright.sim.campaign.breaks import BREAKS, applicable
from heatwright.sim.campaign.drawn import link_name
from heatwright.sim.campaign.vary import (
    ALL,
    LEAST_CAPACITY,
    LEAST_RESISTANCE,
    Spread,
    Vary,
    spread_of,
    vary_of,
)
from heatwright.sim.faults.bears import room_c
from heatwright.sim.faults.site import Place
from heatwright.sim.scenario import end_s
from heatwright.spec import Controller, Problem, Spec
from heatwright.spec.base import ABSOLUTE_ZERO_C
from heatwright.spec.loading.suggest import advice
from heatwright.spec.loading.tree import Tree
from heatwright.spec.problems import Path as KeyPath
from heatwright.spec.quantity import amount, celsius, duration, number
from heatwright.spec.units import (
    CAPACITY,
    DIFFERENCE,
    PERCENT,
    TEMPERATURE,
    THERMAL_RESISTANCE,
    Dimension,
)

EMPTY = "this file is empty", "Write what varies, such as capacities: {all: ± 20 %}"
AROUND_K = 10.0
"""Default deviation of the ambient temperature in both directions, K."""
FAULTS_PERCENT = 20.0


class _Finding(NamedTuple):
    path: KeyPath
    reason: str
    remedy: str


def derived(controller: Controller) -> Vary:
    """Return the variations that are used if no file is given; they suit any machine.

    Heat capacities and resistances vary as much as builders misjudge them, the room is colder or
    hotter, the supply is within its usual tolerance, sensor errors are at most those of the data
    sheets, the operator is late, and about every fifth run has a fault.
    """
    simulation = controller.simulated
    ends_c = [room_c(controller, simulation.ambient_c + sign * AROUND_K) for sign in (-1, 1)]
    errors = {
        loop.sensor: f"± {number(_error_k(controller, loop.sensor, loop.setpoint.maximum_c))} K"
        for loop in controller.loops.values()
    }
    entries = {
        "capacities": {ALL: "± 20 %"},
        "resistances": {ALL: "± 20 %"},
        "ambient": f"{celsius(min(ends_c))} .. {celsius(max(ends_c))}",
        "supply": "± 5 %",
        "errors": errors,
        "faults": {"chance": f"{number(FAULTS_PERCENT)} %"},
    }
    if any(event.at_s is not None for event in simulation.scenario):
        entries["late"] = "0 s .. 10 s"
    return vary_of(entries)


def _error_k(controller: Controller, sensor: str, at_c: float) -> float:
    return float(f"{controller.thermometers[sensor].error_k(at_c):.3g}")


def given(spec: Spec, file: Path | None) -> Vary:
    """Return the variations of the file, or those for any machine.

    Raises SpecError: the file is wrong, with all problems; Refused: the spec has no simulation.
    """
    machine_of(spec)
    if file is None:
        return derived(spec.controller)

    def checked(found: Vary, tree: Tree) -> list[Problem]:
        once = {each.path: each for each in _checked(found, spec.controller)}
        return [tree.problem(*each) for each in once.values()]

    return read_beside(file, Vary, EMPTY, checked)


# -- checked against the spec --------------------------------------------------------------------


def _checked(vary: Vary, controller: Controller) -> Iterator[_Finding]:
    yield from _plant_findings(vary, controller)
    yield from _sensors_findings(vary, controller)
    yield from _events_findings(vary, controller)
    yield from _faults_findings(vary, controller)


def _named(key: str, names: Mapping[str, object], known: Sequence[str]) -> Iterator[_Finding]:
    for name in names:
        if name != ALL and name not in known:
            yield _Finding((key, name), f"there is no {name} in the spec", advice(name, known))


def _bounded(
    path: KeyPath, spread: Spread, own: float, least: float, dimension: Dimension
) -> Iterator[_Finding]:
    low = spread.ends(own)[0]
    if low < least:
        yield _Finding(
            path,
            f"{spread.text} goes down to {amount(low, dimension)}",
            f"Let it stay at {amount(least, dimension)} or above",
        )


def _plant_findings(vary: Vary, controller: Controller) -> Iterator[_Finding]:
    simulation = controller.simulated
    links = {link_name(link): link.resistance_k_per_w for link in simulation.plant.links}
    for key, spreads, owns, least, dimension in (
        ("capacities", vary.capacities, simulation.plant.nodes, LEAST_CAPACITY, CAPACITY),
        ("resistances", vary.resistances, links, LEAST_RESISTANCE, THERMAL_RESISTANCE),
    ):
        yield from _named(key, spreads, list(owns))
        for name, own in owns.items():
            if (spread := spread_of(spreads, name)) is not None:
                written = name if name in spreads else ALL
                yield from _bounded((key, written), spread, own, least, dimension)
    if vary.ambient_c is not None:
        own_c = simulation.ambient_c
        yield from _bounded(("ambient",), vary.ambient_c, own_c, ABSOLUTE_ZERO_C, TEMPERATURE)
    if vary.supply_percent is not None:
        yield from _bounded(("supply",), vary.supply_percent, 100.0, 1.0, PERCENT)


def _sensors_findings(vary: Vary, controller: Controller) -> Iterator[_Finding]:
    sense = controller.simulated.plant.sense
    currents = [name for name in controller.sensors if name not in controller.thermometers]
    thermometers = [name for name in sense if name not in currents]
    yield from _named("errors", vary.errors, list(controller.sensors))
    yield from _named("noise", vary.noise_k, thermometers)
    for name, spread in vary.errors.items():
        if name in controller.ammeters and not spread.is_share:
            reason = f"{name} measures a current, and {spread.text} is not a share of it"
            yield _Finding(("errors", name), reason, "Write a share, such as ± 2 %")
        elif name in thermometers and spread.is_share:
            reason = f"{spread.text} is a share, and an error of a temperature has the unit K"
            yield _Finding(("errors", name), reason, "Write it in K, such as ± 0.5 K")
    for name in thermometers:
        if (noise := spread_of(vary.noise_k, name)) is not None:
            written = name if name in vary.noise_k else ALL
            yield from _bounded(("noise", written), noise, sense[name].noise_k, 0.0, DIFFERENCE)


def _events_findings(vary: Vary, controller: Controller) -> Iterator[_Finding]:
    for number_, ask in enumerate(vary.asks):
        path: KeyPath = ("asks", number_)
        yield from _in_time((*path, "at"), ask.at_s, controller)
        if ask.loop not in controller.loops:
            reason = f"there is no loop {ask.loop} in the spec"
            yield _Finding((*path, "loop"), reason, advice(ask.loop, list(controller.loops)))
            continue
        place, setpoint = Place(controller, ask.loop), controller.loops[ask.loop].setpoint
        if not place.facts.commanded and not place.key_step_k:
            yield _Finding(
                (*path, "loop"),
                f"no keys, host or master can set the setpoint of {ask.loop}",
                "Delete this entry of asks, or add an interface to the spec",
            )
        low_c, high_c = ask.setpoint_c.ends()
        if low_c < setpoint.minimum_c or high_c > setpoint.maximum_c:
            able = f"{celsius(setpoint.minimum_c)} .. {celsius(setpoint.maximum_c)}"
            reason = f"{ask.setpoint_c.text} exceeds the loop's range of setpoints, {able}"
            yield _Finding((*path, "setpoint"), reason, f"Stay within {able}")
    nodes = controller.simulated.plant.nodes
    for number_, upset in enumerate(vary.upsets):
        yield from _in_time(("upsets", number_, "at"), upset.at_s, controller)
        if upset.node is not None and upset.node not in nodes:
            reason = f"there is no node {upset.node} in the plant"
            yield _Finding(("upsets", number_, "node"), reason, advice(upset.node, list(nodes)))


def _in_time(path: KeyPath, at_s: Spread, controller: Controller) -> Iterator[_Finding]:
    length_s = end_s(controller.simulated.scenario)
    if at_s.ends()[1] >= length_s:
        yield _Finding(
            path,
            f"{at_s.text} is not before the end of the scenario, at {duration(length_s)}",
            "Make it earlier",
        )


def _faults_findings(vary: Vary, controller: Controller) -> Iterator[_Finding]:
    if vary.faults is None:
        return
    if vary.faults.at_s is not None:
        yield from _in_time(("faults", "at"), vary.faults.at_s, controller)
    for number_, name in enumerate(vary.faults.of):
        path: KeyPath = ("faults", "of", number_)
        if name not in BREAKS:
            yield _Finding(path, f"there is no fault {name}", advice(name, list(BREAKS)))
        elif not applicable(controller, name):
            reason = f"no loop of the spec has the part that {name} breaks"
            yield _Finding(path, reason, f"Delete {name}")
