"""The simulated plants, one module per kind, found by its name.

`plant: {kind: thermal_network}` is `heatwright.sim.plants.thermal_network.Plant`.
"""

import math
from collections.abc import Mapping
from importlib import import_module
from types import ModuleType
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from heatwright.spec import Controller, Sense, ThermalNetwork, full_a
from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.registry import module_of
from heatwright.spec.sensing.currents import FILTER_PULSES

Temperatures = NDArray[np.float64]
FOREVER_S = 1e7
"""Longer than any machine takes to settle: four months."""


class Plant(Protocol):
    """A machine with heaters and sensors."""

    nodes: tuple[str, ...]
    """Names of the temperatures in `temperatures_c`."""
    heaters: tuple[str, ...]
    """Names of the outputs that give heat."""

    @property
    def temperatures_c(self) -> Temperatures:
        """The present temperature of every node, °C."""

    def sensed_c(self) -> dict[str, float]:
        """Return the present temperature of every sensor's tip, °C."""

    def currents_a(self) -> dict[str, float]:
        """Return the present current at every current sensor, A."""

    def step(
        self,
        active: Mapping[str, float],
        feed_mm_per_s: float = 0.0,
        conducts: Mapping[str, float] | None = None,
    ) -> None:
        """Advance by one step.

        active -- each output's mean active fraction over it, 0..1; feed_mm_per_s -- the filament's
        mean speed over it; conducts -- the same as `active`, but for the currents, if some heat has
        another source.
        """


def plant_module(kind: str) -> ModuleType:
    """Import the module of a kind of plant; slow the first time, because it imports scipy."""
    return import_module(module_of("plant", "plant", kind))


def nodes_of(controller: Controller, plant: ThermalNetwork) -> dict[str, tuple[str, ...]]:
    """Return the nodes of each loop: all but those whose single nearest loop is another one.

    The distance to a loop is the number of links, or of radiating surfaces, to its heated or its
    measured node. A node without a single nearest loop belongs to every loop.
    """
    far = {
        name: _far(plant, {plant.heat[loop.heater], str(plant.sense[loop.sensor].node)})
        for name, loop in controller.loops.items()
    }

    def is_nearest(name: str, node: str) -> bool:
        return all(far[name][node] < far[other][node] for other in far if other != name)

    return {
        name: tuple(
            node for node in plant.nodes
            if not any(is_nearest(other, node) for other in far if other != name)
        )
        for name in far
    }  # fmt: skip


def profile_c(
    controller: Controller, plant: ThermalNetwork, loop: str, level_c: float, *, ambient_c: float
) -> dict[str, float]:
    """Return the temperatures of a loop's nodes after a long time at a sensor temperature, °C.

    Their shares of the rise above ambient are those at full power; below ambient, all nodes are as
    cold as the loop's sensor.
    """
    own, sensor = nodes_of(controller, plant)[loop], controller.loops[loop].sensor
    if level_c <= ambient_c:
        return dict.fromkeys(own, level_c)
    settled = plant_of(
        controller, plant.model_copy(update={"initial_c": ambient_c}), ambient_c=ambient_c,
        step_s=FOREVER_S,
    )  # fmt: skip
    settled.step(full_power(controller, loop))
    sensed_k = settled.sensed_c()[sensor] - ambient_c
    rises = zip(settled.nodes, settled.temperatures_c - ambient_c, strict=True)
    share = (level_c - ambient_c) / sensed_k
    return {node: ambient_c + share * float(rise_k) for node, rise_k in rises if node in own}


def full_power(controller: Controller, loop: str, share: float = 1.0) -> dict[str, float]:
    """Return the shares of all outputs while a loop heats: coolers and other heaters are off."""
    others = {each.heater for each in controller.loops.values()}
    others |= {each.cooler for each in controller.loops.values() if each.cooler}
    asked = dict.fromkeys(controller.outputs, 1.0) | dict.fromkeys(others, 0.0)
    return asked | {controller.loops[loop].heater: share}


def _far(plant: ThermalNetwork, near: set[str]) -> dict[str, float]:
    """Return the distance from each node to the nearest of some nodes, in links."""
    far = {node: 0.0 if node in near else math.inf for node in plant.nodes}
    ends = [link.between for link in plant.links]
    ends += [surface.between for surface in plant.radiation]
    for _ in plant.nodes:
        for here, there in ends:
            if here in far and there in far:
                far[here] = min(far[here], far[there] + 1)
                far[there] = min(far[there], far[here] + 1)
    return far


def plant_of(  # noqa: PLR0913 - all but two are named
    controller: Controller,
    plant: ThermalNetwork,
    *,
    ambient_c: float,
    step_s: float,
    seed: int = 0,
    starts_c: Mapping[str, float] | None = None,
    errors: Mapping[str, float] | None = None,
) -> Plant:
    """Build the plant of a spec for a fixed time step.

    controller -- gives the power of the outputs; plant -- the thermal network; ambient_c -- ambient
    temperature, °C; step_s -- time step of the simulation, s; seed -- seed of the noise;
    starts_c -- temperatures of nodes that start at another temperature, °C; errors -- constant
    errors by sensor: of a tip in K, of a current as a share of it.
    """
    module = plant_module(plant.kind)
    powers_w = powers_of(controller)
    return cast(
        "Plant",
        module.Plant(
            plant.model_copy(update={"sense": _filtered(controller, plant)}),
            powers_w,
            ambient_c=ambient_c,
            step_s=step_s,
            seed=seed,
            full_a=_currents_of(controller),
            starts_c=starts_c,
            errors=errors,
        ),
    )


def _filtered(controller: Controller, plant: ThermalNetwork) -> dict[str, Sense]:
    """Return the spec's sensors; the current sensors have at least the shortest filter."""
    found = dict(plant.sense)
    for name, sense in plant.sense.items():
        output = controller.outputs.get(sense.of or "")
        if output and output.frequency_hz and not sense.lag_s:
            lag_s = FILTER_PULSES / output.frequency_hz
            found[name] = sense.model_copy(update={"lag_s": lag_s})
    return found


def _currents_of(controller: Controller) -> dict[str, float]:
    """Return the current of each output while it is on, A, if power and supply are given."""
    currents = {name: full_a(output) for name, output in controller.switches.items()}
    return {name: amperes for name, amperes in currents.items() if amperes is not None}


def supplied(controller: Controller, share: float) -> Controller:
    """Multiply the supply voltage of all loads; without a rated voltage, their power follows it."""
    outputs = dict(controller.outputs)
    for name, output in controller.outputs.items():
        volts, watts = output.supply_v, output.power_w
        changes = {} if volts is None else {"supply_v": volts * share}
        if watts is not None and output.rated_v is None:
            changes["power_w"] = watts * share**2
        outputs[name] = output.model_copy(update=changes)
    return controller.model_copy(update={"outputs": ReadOnlyDict(outputs)})


def powers_of(controller: Controller) -> dict[str, float]:
    """Return the power of each output while it is on, W; 0 for outputs that do not heat.

    A heater with a rated voltage below its supply takes more than its rated power while it is on.
    """
    return {
        name: (output.power_w or 0.0) / output.full_share
        for name, output in controller.outputs.items()
    }
