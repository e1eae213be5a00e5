"""The kiln's firings: the binary's, and the model's on machines that are off by some."""

from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from machines import events, example

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.trace import Trace
from heatwright.spec import Controller, load
from heatwright.spec.base import ReadOnlyDict

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"
LOOP = "chamber"

IDLE, RUNNING, PAUSED, RETURNING, RESTORING = range(5)
FINISHED, STOPPED, FAILED, POWER_COLD = range(1, 5)
OVER, RATE, FAST, HOLD, UNTIL = range(1, 6)


class Fired(NamedTuple):
    device: AvrDevice
    trace: Trace
    log: Any
    """Time of the processor that it took, s."""


@cache
def binary(folder: Path, name: str = "kiln") -> Path:
    """Build an example."""
    write(render(plan_firmware(load(EXAMPLES / f"{name}.yaml"))), folder)
    return build(folder).elf


def fire(elf: Path, *lines: dict[str, Any], controller: Controller | None = None) -> Fired:
    """Run the binary through a scenario; the specification's own if none is given."""
    controller = controller or example("kiln")
    device = AvrDevice(controller, elf)
    trace = bench(controller, device, events(*lines) if lines else None)
    return Fired(device, trace, trace.steps[LOOP])


def modelled(controller: Controller, *lines: dict[str, Any], seed: int = 0) -> Trace:
    """Run the model through a scenario."""
    return bench(controller, ReferenceDevice(controller), events(*lines), seed=seed)


def noisy(controller: Controller, noise_k: float) -> Controller:
    """The same with a sensor that is so noisy."""
    assert controller.simulation is not None
    plant = controller.simulation.plant
    sense = {
        name: each.model_copy(update={"noise_k": noise_k}) for name, each in plant.sense.items()
    }
    changed = plant.model_copy(update={"sense": ReadOnlyDict(sense)})
    simulation = controller.simulation.model_copy(update={"plant": changed})
    return controller.model_copy(update={"simulation": simulation})


def course(log: Any, *names: str) -> list[tuple[int, ...]]:
    """What members of the program are, each time one of them changes."""
    rows = [tuple(int(log[f"program.{name}"][row]) for name in names) for row in range(len(log))]
    return [row for row, before in zip(rows, [None, *rows], strict=False) if row != before]
