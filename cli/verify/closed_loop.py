"""Runs the spec's scenario with the unmodified binary, and replays its steps with the model."""

from dataclasses import dataclass
from pathlib import Path

from heatwright.cli.running import Run, run_binary
from heatwright.cli.talk import Job
from heatwright.sim.binary.elf import Elf
from heatwright.sim.replay import ReplayResult, replay_all
from heatwright.sim.scenario import long_enough
from heatwright.spec import Controller


@dataclass(frozen=True)
class ClosedLoop:
    """The run of the binary, and the replay of each loop."""

    run: Run
    replays: dict[str, ReplayResult]


def closed_loop(controller: Controller, elf: Path | Elf, job: Job) -> ClosedLoop:
    """Run the scenario and replay its steps."""
    run = run_binary(long_enough(controller), elf, job)
    return ClosedLoop(run, replay_all(controller, run.trace.steps))
