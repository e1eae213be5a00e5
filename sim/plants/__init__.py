"""The simulated machines, one module per kind of plant, found by its stem.

`plant: {kind: thermal_network}` is `heatwright.sim.plants.thermal_network.Plant`.
"""

from collections.abc import Mapping
from importlib import import_module
from types import ModuleType
from typing import Protocol, cast

import numpy as np
from numpy.typing import NDArray

from heatwright.spec import Controller, Stepper, ThermalNetwork, full_a

Temperatures = NDArray[np.float64]


class Plant(Protocol):
    """A machine that outputs heat and sensors feel."""

    nodes: tuple[str, ...]
    """Names of the temperatures in `temperatures_c`."""

    @property
    def temperatures_c(self) -> Temperatures:
        """The temperature of every node now, °C."""

    def sensed_c(self) -> dict[str, float]:
        """Return what every sensor's tip feels now, °C."""

    def currents_a(self) -> dict[str, float]:
        """Return what every current's sensor sees now, A."""

    def step(
        self,
        active: Mapping[str, float],
        feed_mm_per_s: float = 0.0,
        conducts: Mapping[str, float] | None = None,
    ) -> None:
        """Go on by one step.

        Args:
            active: each output's mean active fraction over it, 0..1.
            feed_mm_per_s: the filament's mean speed over it.
            conducts: the same for their currents, where some of the heat comes from elsewhere.

        """


def plant_module(kind: str) -> ModuleType:
    """Import the plants of a kind; the first time it takes a while, for they bring scipy."""
    return import_module(f"heatwright.sim.plants.{kind}")


def plant_of(
    controller: Controller, plant: ThermalNetwork, *, ambient_c: float, step_s: float, seed: int = 0
) -> Plant:
    """Build the machine of a specification for a fixed time step.

    Args:
        controller: gives the power of the outputs.
        plant: the machine.
        ambient_c: temperature of the surroundings, °C.
        step_s: time step of the simulation, s.
        seed: of the sensor noise.

    """
    module = plant_module(plant.kind)
    powers_w = powers_of(controller)
    return cast(
        "Plant",
        module.Plant(
            plant,
            powers_w,
            ambient_c=ambient_c,
            step_s=step_s,
            seed=seed,
            full_a=_currents_of(controller),
        ),
    )


def _currents_of(controller: Controller) -> dict[str, float]:
    """Return the current of each output while it is on, A, where power and supply tell it."""
    currents = {
        name: full_a(output)
        for name, output in controller.outputs.items()
        if not isinstance(output, Stepper)
    }
    return {name: amperes for name, amperes in currents.items() if amperes is not None}


def powers_of(controller: Controller) -> dict[str, float]:
    """Return the power of each output while it is on, W; 0 for what heats nothing.

    A heater that is rated for less than its supply takes more than its power while it is on.
    """
    return {
        name: (getattr(output, "power_w", None) or 0.0) / getattr(output, "full_share", 1.0)
        for name, output in controller.outputs.items()
    }
