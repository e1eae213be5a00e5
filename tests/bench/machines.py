"""The extruder and the feeder, their machines off by some, and what tuning finds on them."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.reference.inputs import Gains
from heatwright.sim.trace import Trace
from heatwright.spec import Controller, Event, load

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"
OFF_BY = (1.0, 0.7, 1.3)
PLANTS = [(capacity, resistance) for capacity in OFF_BY for resistance in OFF_BY]


@cache
def example(name: str) -> Controller:
    return load(EXAMPLES / f"{name}.yaml").controller


def scaled(controller: Controller, capacity: float, resistance: float) -> Controller:
    """The same controller on a machine whose capacity and resistance are so many times as large."""
    assert controller.simulation is not None
    plant = controller.simulation.plant
    nodes = {name: capacity * value for name, value in plant.nodes.items()}
    links = tuple(
        link.model_copy(update={"resistance_k_per_w": resistance * link.resistance_k_per_w})
        for link in plant.links
    )
    changed = plant.model_copy(update={"nodes": nodes, "links": links})
    simulation = controller.simulation.model_copy(update={"plant": changed})
    return controller.model_copy(update={"simulation": simulation})


def events(*lines: dict[str, Any]) -> list[Event]:
    return [Event.model_validate(line) for line in lines]


@dataclass(frozen=True)
class Tuned:
    gains: Gains
    log: Any

    @property
    def line(self) -> str:
        """What sets these gains, to the last bit."""
        kp, ki, kd = (np.format_float_positional(gain) for gain in self.gains)
        return f"M301 P{kp} I{ki} D{kd}"


@cache
def tuned(name: str, target_c: float, capacity: float = 1.0, resistance: float = 1.0) -> Tuned:
    """Tune on a machine, from cold."""
    controller = scaled(example(name), capacity, resistance)
    device = ReferenceDevice(controller)
    lines = events({"at": "1 s", "send": f"M303 S{target_c:g}"}, {"for": "500 s"})
    log = bench(controller, device, lines).steps["nozzle"]
    assert device.gains is not None
    return Tuned(device.gains, log)


def run(controller: Controller, first: str, *lines: dict[str, Any]) -> Trace:
    """Run a scenario after a first command."""
    device = ReferenceDevice(controller)
    device.send(first)
    return bench(controller, device, events(*lines))
