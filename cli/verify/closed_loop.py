"""The spec's scenario, by the unmodified binary, and the same steps by the reference model."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from heatwright.cli.running import Run, run_binary
from heatwright.cli.talk import Job
from heatwright.sim.replay import ReplayResult, replay_all
from heatwright.spec import Controller, Event

LEAST_S = 1800.0
"""A shorter scenario is drawn out to this length: counters that wrap or drift show late."""


@dataclass(frozen=True)
class ClosedLoop:
    """The run, and its replay by loop."""

    run: Run
    replays: dict[str, ReplayResult]


def closed_loop(controller: Controller, elf: Path, job: Job) -> ClosedLoop:
    """Run and replay."""
    run = run_binary(long_enough(controller), elf, job)
    return ClosedLoop(run, replay_all(controller, run.trace.steps))


def long_enough(controller: Controller) -> Controller:
    """Draw a short scenario out."""
    simulation = controller.simulation
    assert simulation is not None  # noqa: S101 - looked at before
    scenario = tuple(
        event.model_copy(update={"for_s": LEAST_S}) if _is_short(event) else event
        for event in simulation.scenario
    )
    longer = simulation.model_copy(update={"scenario": scenario})
    return controller.model_copy(update={"simulation": longer})


def _is_short(event: Event) -> bool:
    return event.for_s is not None and event.for_s < LEAST_S
