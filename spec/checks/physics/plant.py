"""The simulated machine: names that exist, heat that reaches the sensors and ambient, sensors."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.references import current_sensors, unknown
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path
from heatwright.spec.simulation import AMBIENT, ThermalNetwork

MOST_NODES = 16
"""Maximum number of nodes of a network: the time of its checks grows with their third power."""

_PLANT: Path = ("simulation", "plant")


def plant_names(controller: Controller, plant: ThermalNetwork) -> Findings:
    """Find undefined nodes, outputs and sensors that the plant names."""
    nodes = plant.nodes
    for output, node in plant.heat.items():
        yield from unknown((*_PLANT, "heat", output), output, "outputs", controller.outputs)
        yield from unknown((*_PLANT, "heat", output), node, "nodes", nodes)
    for sensor, sense in plant.sense.items():
        yield from unknown((*_PLANT, "sense", sensor), sensor, "sensors", controller.sensors)
        if sense.node is not None:
            yield from unknown((*_PLANT, "sense", sensor, "node"), sense.node, "nodes", nodes)
        if sense.of is not None:
            where = (*_PLANT, "sense", sensor, "of")
            yield from unknown(where, sense.of, "outputs", controller.outputs)
    if plant.filament is not None:
        yield from unknown((*_PLANT, "filament", "node"), plant.filament.node, "nodes", nodes)
    for fan in plant.fans:
        yield from unknown((*_PLANT, "fans", fan), fan, "outputs", controller.outputs)
    for node in plant.bears_c:
        yield from unknown((*_PLANT, "bears", node), node, "nodes", nodes)
    yield from _ends_exist(plant)


def _ends_exist(plant: ThermalNetwork) -> Findings:
    for key, pairs in (
        ("links", [link.between for link in plant.links]),
        ("radiation", [surface.between for surface in plant.radiation]),
    ):
        for index, between in enumerate(pairs):
            for end in between:
                path = (*_PLANT, key, index, "between")
                yield from unknown(path, end, "nodes", (*plant.nodes, AMBIENT))


def plant_links(_: Controller, plant: ThermalNetwork) -> Findings:
    """Find links from a node to itself, links given twice, and fans of links that do not exist."""
    first: dict[frozenset[str], int] = {}
    for index, link in enumerate(plant.links):
        path = (*_PLANT, "links", index, "between")
        ends = frozenset(link.between)
        if len(ends) == 1:
            yield Finding(path, "a link needs two different ends", "Name another node")
        elif first.setdefault(ends, index) != index:
            yield Finding(
                path,
                f"{' and '.join(link.between)} are already linked by links[{first[ends]}]",
                "Join the two resistances into one: 1/(1/R1 + 1/R2)",
            )
    for fan, effect in plant.fans.items():
        if frozenset(effect.link) not in first:
            yield Finding(
                (*_PLANT, "fans", fan, "link"),
                f"there is no link between {' and '.join(effect.link)}",
                "Name the two ends of a link",
                ((*_PLANT, "links"),),
            )


def plant_radiation(_: Controller, plant: ThermalNetwork) -> Findings:
    """Find surfaces that radiate to themselves."""
    for index, surface in enumerate(plant.radiation):
        if surface.between[0] == surface.between[1]:
            path = (*_PLANT, "radiation", index, "between")
            yield Finding(path, "radiation needs two different ends", "Name another node")


def plant_nodes(_: Controller, plant: ThermalNetwork) -> Findings:
    """Find a node called ambient, too many nodes, and nodes whose heat cannot reach ambient."""
    if AMBIENT in plant.nodes:
        yield Finding(
            (*_PLANT, "nodes", AMBIENT),
            "ambient is the surroundings, which have no heat capacity",
            "Give the node another name",
        )
    if len(plant.nodes) > MOST_NODES:
        yield Finding(
            (*_PLANT, "nodes"),
            f"the network has {len(plant.nodes)} nodes",
            f"Use at most {MOST_NODES}; join nodes that always have the same temperature",
        )
    reached = _reached(plant, AMBIENT)
    for node in plant.nodes:
        if node not in reached:
            yield Finding(
                (*_PLANT, "nodes", node),
                "no chain of links leads from this node to ambient, so its heat could never leave",
                "Add a link",
                ((*_PLANT, "links"), (*_PLANT, "radiation")),
            )


def _reached(plant: ThermalNetwork, start: str) -> set[str]:
    """Follow the links from a node; they lead into ambient but not on from there.

    Radiating surfaces count as links, too.
    """
    reached, ahead = {start}, [start]
    pairs = [link.between for link in plant.links]
    pairs += [surface.between for surface in plant.radiation]
    while ahead:
        node = ahead.pop()
        for between in pairs:
            if node in between:
                for end in set(between) - reached:
                    reached.add(end)
                    if end != AMBIENT:
                        ahead.append(end)
    return reached


def heat_arrives(controller: Controller, plant: ThermalNetwork) -> Findings:
    """Find heaters whose heat never reaches their loop's sensor."""
    for name, loop in controller.loops.items():
        if loop.heater in plant.heat and loop.sensor in plant.sense:
            heated, sensed = plant.heat[loop.heater], plant.sense[loop.sensor].node
            if sensed is not None and sensed not in _reached(plant, heated):
                yield Finding(
                    (*_PLANT, "links"),
                    f"no chain of links leads from {heated}, which {loop.heater} heats, to "
                    f"{sensed}, where {loop.sensor} measures for the loop {name}",
                    "Add a link",
                )


def plant_covers_loops(controller: Controller, plant: ThermalNetwork) -> Findings:
    """Find sensors and heaters of loops that the plant's `sense` and `heat` do not list."""
    for name, loop in controller.loops.items():
        if loop.sensor not in plant.sense and loop.sensor in controller.sensors:
            yield Finding(
                (*_PLANT, "sense"),
                f"the sensor '{loop.sensor}' of the loop '{name}' has no entry",
                f"Add {loop.sensor}: {{node: …}}",
                (("loops", name), ("sensors", loop.sensor)),
            )
        if loop.heater not in plant.heat and loop.heater in controller.outputs:
            yield Finding(
                (*_PLANT, "heat"),
                f"the heater '{loop.heater}' of the loop '{name}' has no entry",
                f"Add {loop.heater}: with the name of the node that it heats",
                (("loops", name), ("outputs", loop.heater)),
            )


def heaters_have_power(controller: Controller) -> Findings:
    """Find heaters of the plant that are steppers, or without a power."""
    if controller.simulation is None:
        return
    for name in controller.simulation.plant.heat:
        output = controller.outputs.get(name)
        if output and output.feeds:
            yield Finding(
                (*_PLANT, "heat", name),
                f"{name} is a stepper, which feeds material and cannot heat",
                "Delete it",
                (("outputs", name),),
            )
        elif output is not None and output.power_w is None:
            yield Finding(
                ("outputs", name),
                "the plant needs the power of this heater",
                "Add power: with its watts, such as 240 W",
                ((*_PLANT, "heat"),),
            )


_SENSE: Path = (*_PLANT, "sense")


def senses_fit(controller: Controller, plant: ThermalNetwork) -> Findings:
    """Find temperature sensors at an output, and current sensors at a node or another output."""
    used = {sensor: output for output, sensor in current_sensors(controller).items()}
    for name, sense in plant.sense.items():
        path = (*_SENSE, name)
        because_of: tuple[Path, ...] = (("sensors", name), ("outputs",))
        if sense.node is not None and name in controller.ammeters:
            yield Finding(
                (*path, "node"),
                f"{name} measures a current, and a node has none",
                f"Write of: {used.get(name, '…')} in place of node",
                because_of,
            )
        elif sense.of is not None and name not in controller.ammeters:
            yield Finding(
                (*path, "of"),
                f"{name} measures a temperature, and an output has none",
                "Delete of, and add node: with the node that it measures",
                because_of,
            )
        elif sense.of is not None and used.get(name, sense.of) != sense.of:
            yield Finding(
                (*path, "of"),
                f"{name} measures the current of {used[name]}",
                f"Write of: {used[name]}",
                because_of,
            )


def currents_are_sensed(controller: Controller, plant: ThermalNetwork) -> Findings:
    """Find current sensors that the plant's `sense` does not list."""
    for output, sensor in current_sensors(controller).items():
        if sensor in controller.sensors and sensor not in plant.sense:
            yield Finding(
                _SENSE,
                f"the current sensor '{sensor}' of the output '{output}' has no entry",
                f"Add {sensor}: {{of: {output}}}",
                (("sensors", sensor), ("outputs", output)),
            )
