"""The examples' machines, off by some; runs of their models, and of their binaries, each once."""

from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

from rig.specs import controller_of as example

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.faults.healthy import scaled as scaled_network
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
    plant = scaled_network(controller.simulation.plant, capacity, resistance)
    return on_plant(controller, nodes=plant.nodes, links=plant.links)


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


def run_on(device: Any, controller: Controller, lines: Lines, seed: int = 0) -> Run:
    """Run a device through a scenario; the specification's own if none is given."""
    trace = bench(controller, device, events(*lines) if lines else None, seed=seed)
    return Run(controller, device, trace)


def modelled(controller: Controller | str, *lines: Mapping[str, Any], seed: int = 0) -> Run:
    """Run the model through a scenario; the specification's own if none is given."""
    found = example(controller) if isinstance(controller, str) else controller
    return run_on(ReferenceDevice(found), found, lines, seed)


def course(log: Any, *names: str) -> list[tuple[Any, ...]]:
    """What members of the log are, each time one of them changes."""
    rows = [tuple(log[name][row].item() for name in names) for row in range(len(log))]
    return [row for row, before in zip(rows, [None, *rows], strict=False) if row != before]


@cache
def tuned(name: str, target_c: float, capacity: float, resistance: float) -> Run:
    """Tune on a machine, from cold."""
    controller = scaled(example(name), capacity, resistance)
    return modelled(controller, *at({1: f"M303 S{target_c:g}"}), {"for": "500 s"})
