"""Sensors of the simulated machine: they measure temperatures of nodes or currents of outputs."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.references import current_sensors
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path
from heatwright.spec.simulation import ThermalNetwork

_SENSE: Path = ("simulation", "plant", "sense")


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
                f"the sensor of the current of {output}, '{sensor}', has no entry",
                f"Add {sensor}: {{of: {output}}}",
                (("sensors", sensor), ("outputs", output)),
            )
