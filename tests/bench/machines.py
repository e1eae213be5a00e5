"""The examples' machines, off by some; runs of their models, and of their binaries, each once."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from rig import specs
from rig.avr import whole

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.reference.inputs import Gains
from heatwright.sim.trace import Trace
from heatwright.sim.tuning import gains as tuning
from heatwright.sim.tuning.margins import margins
from heatwright.sim.tuning.process import process_of
from heatwright.spec import Controller, Event
from heatwright.spec.base import ReadOnlyDict

OFF_BY = (1.0, 0.7, 1.3)
PLANTS = [(capacity, resistance) for capacity in OFF_BY for resistance in OFF_BY]
Lines = tuple[Mapping[str, Any], ...]


def example(name: str) -> Controller:
    return specs.example(name).controller


def events(*lines: Mapping[str, Any]) -> list[Event]:
    return [Event.model_validate(line) for line in lines]


def at(said: Mapping[float, Any], verb: str = "send") -> Lines:
    """What is said at which time."""
    return tuple({"at": f"{time_s} s", verb: line} for time_s, line in said.items())


# ---- machines that are off by some ----


def on_plant(controller: Controller, **changes: Any) -> Controller:
    """The same controller on a machine with changes."""
    assert controller.simulation is not None
    plant = controller.simulation.plant.model_copy(update=changes)
    simulation = controller.simulation.model_copy(update={"plant": plant})
    return controller.model_copy(update={"simulation": simulation})


def scaled(controller: Controller, capacity: float, resistance: float) -> Controller:
    """The same controller on a machine whose capacity and resistance are so many times as large."""
    assert controller.simulation is not None
    plant = controller.simulation.plant
    links = tuple(
        link.model_copy(update={"resistance_k_per_w": resistance * link.resistance_k_per_w})
        for link in plant.links
    )
    nodes = {name: capacity * value for name, value in plant.nodes.items()}
    return on_plant(controller, nodes=nodes, links=links)


def noisy(controller: Controller, noise_k: float) -> Controller:
    """The same with a sensor that is so noisy."""
    assert controller.simulation is not None
    sense = controller.simulation.plant.sense
    changed = {name: each.model_copy(update={"noise_k": noise_k}) for name, each in sense.items()}
    return on_plant(controller, sense=ReadOnlyDict(changed))


def assert_margins(
    controller: Controller,
    gains: Gains | None = None,
    at_c: float | None = None,
    *,
    gain: float = 2.0,
    phase_deg: float = 45.0,
) -> None:
    """See that the only loop keeps what every tuned loop here is held to, at a temperature."""
    ((name, loop),) = controller.loops.items()
    own = loop.algorithm
    kp, ki, kd = map(float, gains or (own.kp, own.ki, own.kd))
    parallel = tuning.Gains(kp, ki, kd, own.derivative_filter_s)
    found = margins(process_of(controller, name, at_c), parallel, loop.period_s)
    assert found.stable
    assert found.gain >= gain
    assert found.phase_deg >= phase_deg


# ---- runs ----


class Run(NamedTuple):
    """What a device was told, and what it did."""

    controller: Controller
    device: Any
    trace: Trace

    @property
    def log(self) -> Any:
        (log,) = self.trace.steps.values()
        return log

    def between(self, from_s: float, to_s: float) -> Any:
        """The log of a part of the time."""
        return self.log[(self.log["time_s"] > from_s) & (self.log["time_s"] < to_s)]


def modelled(controller: Controller | str, *lines: Mapping[str, Any], seed: int = 0) -> Run:
    """Run the model through a scenario; the specification's own if none is given."""
    found = example(controller) if isinstance(controller, str) else controller
    device = ReferenceDevice(found)
    return Run(found, device, bench(found, device, events(*lines) if lines else None, seed=seed))


def fired(name: str, *lines: Mapping[str, Any], device: type[AvrDevice] = AvrDevice) -> Run:
    """Run an example's binary through a scenario; its own if none is given."""
    made = device(example(name), whole(name))
    trace = bench(example(name), made, events(*lines) if lines else None)
    return Run(example(name), made, trace)


def course(log: Any, *names: str) -> list[tuple[Any, ...]]:
    """What members of the log are, each time one of them changes."""
    rows = [tuple(log[name][row].item() for name in names) for row in range(len(log))]
    return [row for row, before in zip(rows, [None, *rows], strict=False) if row != before]


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
    found = modelled(controller, *at({1: f"M303 S{target_c:g}"}), {"for": "500 s"})
    assert found.device.gains is not None
    return Tuned(found.device.gains, found.log)


def commanded(name: str, first: str, *lines: Mapping[str, Any]) -> Run:
    """Run an example's model through a scenario after a first command."""
    device = ReferenceDevice(example(name))
    device.send(first)
    return Run(example(name), device, bench(example(name), device, events(*lines)))
