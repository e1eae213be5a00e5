"""The structure of the plant to find, as a thermal network, and its parameters."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from heatwright.sim.trace import Series
from heatwright.spec import Link, Sense, ThermalNetwork
from heatwright.spec.simulation import AMBIENT

LAG, DELAY, AMBIENT_C = "lag", "delay", "ambient"


class Parameter(NamedTuple):
    """One number of the plant."""

    key: str
    title: str
    unit: str
    logarithmic: bool
    """Always above 0, and fitted by its logarithm."""


@dataclass(frozen=True)
class Names:
    """The names of the parts in the plant."""

    body: str = "body"
    shell: str = "shell"
    heater: str = "heater"
    sensor: str = "sensor"


@dataclass(frozen=True)
class Structure:
    """One body that is heated and measured, with or without a second one around it.

    With two, the heat flows body – shell – ambient. The sensor follows the body with its lag and a
    dead time.
    """

    bodies: int = 1
    names: Names = Names()

    @property
    def nodes(self) -> tuple[str, ...]:
        """Names of the bodies, from the inside out."""
        return (self.names.body, self.names.shell)[: self.bodies]

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Capacities and resistances from the inside out, then lag, dead time and ambient."""
        ends = (*self.nodes[1:], AMBIENT)
        found: list[Parameter] = []
        for node, end in zip(self.nodes, ends, strict=True):
            found += [
                Parameter(f"capacity_{node}", f"heat capacity of {node}", "J/K", True),
                Parameter(f"resistance_{node}", f"resistance {node} – {end}", "K/W", True),
            ]
        return (
            *found,
            Parameter(LAG, "lag of the sensor", "s", False),
            Parameter(DELAY, "dead time", "s", False),
            Parameter(AMBIENT_C, "ambient", "°C", False),
        )

    def network(self, values: Series) -> ThermalNetwork:
        """Build the network of these parameters, without a check whether they are plausible."""
        size = 2 * self.bodies
        ends = (*self.nodes[1:], AMBIENT)
        links = tuple(
            Link.model_construct(between=(node, end), resistance_k_per_w=float(values[2 * i + 1]))
            for i, (node, end) in enumerate(zip(self.nodes, ends, strict=True))
        )
        sense = Sense.model_construct(
            node=self.names.body,
            lag_s=float(values[size]),
            delay_s=float(values[size + 1]),
            noise_k=0.0,
        )
        return ThermalNetwork.model_construct(
            kind="thermal_network",
            nodes={node: float(values[2 * i]) for i, node in enumerate(self.nodes)},
            links=links,
            heat={self.names.heater: self.names.body},
            sense={self.names.sensor: sense},
            initial_c=None,
            fans={},
        )

    @property
    def states(self) -> int:
        """Number of temperatures at the start of a record: of each body, and of the sensor."""
        return self.bodies + 1

    def cooling_s(self, values: Series) -> float:
        """Return the plant's time constant: all heat capacity times all resistance, s."""
        size = 2 * self.bodies
        return float(np.sum(values[0:size:2]) * np.sum(values[1:size:2]))
