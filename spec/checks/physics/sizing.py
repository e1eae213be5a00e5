"""Entries of `sizing`: they need a loop that heats, and a heater whose wire can be computed."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.references import unknown
from heatwright.spec.controller import Controller
from heatwright.spec.outputs import Switch
from heatwright.spec.physics.sizing import Wire
from heatwright.spec.problems import Path
from heatwright.spec.quantity import celsius


def wire_voltage_v(wire: Wire, heater: Switch) -> float | None:
    """Return the voltage at which a wire gives the heater's power, V; None if none is given."""
    own = (wire.voltage_v, heater.rated_v, heater.supply_v)
    return next((float(each) for each in own if each is not None), None)


def sizings_fit(controller: Controller) -> Findings:
    """Find sizings of a loop that is undefined or never heats, and wires without a voltage."""
    simulation = controller.simulation
    if simulation is None:
        return
    for name, sizing in simulation.sizing.items():
        path: Path = ("simulation", "sizing", name)
        yield from unknown(path, name, "loops", controller.loops)
        loop = controller.loops.get(name)
        if loop is None:
            continue
        if loop.setpoint.maximum_c <= simulation.ambient_c:
            yield Finding(
                path,
                f"the highest setpoint of {celsius(loop.setpoint.maximum_c)} is not above the "
                f"ambient temperature of {celsius(simulation.ambient_c)}: there is nothing to heat",
                "Delete it, or raise the setpoint's maximum",
                (("simulation", "ambient"), ("loops", name, "setpoint")),
            )
        heater = controller.switches.get(loop.heater)
        if sizing.wire is None or heater is None:
            continue
        if wire_voltage_v(sizing.wire, heater) is None:
            yield Finding(
                (*path, "wire"),
                "a wire is computed from its power and voltage, and neither the wire nor the "
                f"heater {loop.heater} has a voltage",
                "Add voltage:, as in voltage: 24 V",
                (("outputs", loop.heater),),
            )
