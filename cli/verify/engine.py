"""Gathers the evidence: build, sensors, closed loop, replay, faults, timing."""

from __future__ import annotations

from heatwright.cli.ends import Refused
from heatwright.cli.firmware import build_firmware
from heatwright.cli.talk import Talk
from heatwright.cli.verify.checks import build_checks, chain_checks, replay_checks, run_checks
from heatwright.cli.verify.closed_loop import closed_loop
from heatwright.cli.verify.evidence import Evidence
from heatwright.cli.verify.trials import try_all
from heatwright.sim.chain import chain_errors
from heatwright.spec import Spec


def verify(file: str, spec: Spec, shown: Talk) -> Evidence:
    """Gather and judge.

    Raises Refused for a spec without simulation, ToolMissing, BuildFailed, SimulatorMissing.
    """
    simulation = spec.controller.simulation
    if simulation is None:
        raise Refused(
            f"{spec.file_name}: has no `simulation`, so there is no machine to run it on. "
            "Describe one, as `heatwright init` shows."
        )
    built = build_firmware(spec, shown.begin("Building the firmware"))
    loops = closed_loop(spec.controller, built.elf, shown.begin("Simulating the closed loop"))
    chains = tuple(chain_errors(spec.controller, built.elf))
    return Evidence(
        file=file,
        spec=spec,
        built=built,
        chains=chains,
        loops=loops,
        checks=(
            *build_checks(built),
            *chain_checks(chains),
            *replay_checks(loops),
            *run_checks(loops, simulation.expect),
        ),
        trials=try_all(spec.controller, built, shown),
    )
