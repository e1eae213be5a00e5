"""Gathers the evidence: build, sensors, closed loop, replay, faults, timing.

The binary may have been built elsewhere, if it belongs to the spec.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from heatwright.cli.beside import machine_of
from heatwright.cli.ends import Refused
from heatwright.cli.firmware import build_firmware
from heatwright.cli.fits import DoesNotFit, misfit
from heatwright.cli.talk import Talk
from heatwright.cli.verify.checks import (
    build_checks,
    chain_checks,
    replay_checks,
    run_checks,
    upset_checks,
)
from heatwright.cli.verify.evidence import Evidence
from heatwright.cli.verify.trials import program_of, try_all, try_upsets
from heatwright.generator.toolchain import BuildFailed, BuildResult, TooLarge
from heatwright.generator.toolchain.build import given, refuse_other_chip
from heatwright.sim.avr import Core
from heatwright.sim.binary.dwarf import Variables
from heatwright.sim.binary.elf import Elf, ElfError
from heatwright.sim.chain import chain_errors
from heatwright.sim.device import DIGEST, StaleBinary, check_digest
from heatwright.spec import Spec
from heatwright.spec.loading.user_file import read_file


class Upsets(NamedTuple):
    """The upsets to try: their numbers, and the seed that they are drawn from."""

    numbers: range
    seed: int


NO_UPSETS = Upsets(range(0), 0)


def verify(  # noqa: PLR0913 - what is judged, and how
    file: str,
    spec: Spec,
    shown: Talk,
    *,
    core: Core = "own",
    elf: Path | None = None,
    upsets: Upsets = NO_UPSETS,
    only: Sequence[str] = (),
) -> Evidence:
    """Gather the evidence and judge it.

    core -- the simulator core that runs the instructions; elf -- a binary that was built elsewhere;
    upsets -- the bit flips to try; only -- the faults to try, empty: all. Raises ToolMissing,
    BuildFailed, SimulatorMissing; Refused: the spec has no simulation, the binary is not from this
    spec, or the machine lacks a fault of `only`.
    """
    machine_of(spec)
    if elf is None:
        built = build_firmware(spec, shown.begin("Building the firmware"))
        return _gathered(file, spec, built, core, shown, upsets, only)
    try:
        return _gathered(file, spec, given_binary(spec, elf), core, shown, upsets, only, elf)
    except ElfError as error:
        raise Refused(str(error)) from None


def _gathered(  # noqa: PLR0913, PLR0917 - handed on by the one caller
    file: str,
    spec: Spec,
    built: BuildResult,
    core: Core,
    shown: Talk,
    upsets: Upsets,
    only: Sequence[str],
    elf: Path | None = None,
) -> Evidence:
    program = program_of(built.elf)
    chains = tuple(chain_errors(spec.controller, program))
    trials = try_all(spec.controller, built, core, shown, only)
    flipped = try_upsets(spec.controller, built, core, *upsets, shown) if upsets.numbers else ()
    return Evidence(
        file=file,
        spec=spec,
        core=core,
        elf=elf,
        built=built,
        chains=chains,
        checks=(
            *build_checks(built),
            *chain_checks(chains),
            *replay_checks(trials.loops),
            *run_checks(trials.loops, spec.controller.simulated),
            *upset_checks(flipped),
        ),
        trials=trials,
        upsets=flipped,
    )


def given_binary(spec: Spec, path: Path) -> BuildResult:
    """Check the binary against the spec, and measure the memory that it takes.

    Raises Refused: it is no AVR program, not for this chip or not from this spec, or it cannot be
    verified because names or debug information are missing.
    """
    read_file(path, 0)  # refuses a pipe, which might never end
    try:
        program = Elf(path)
        refuse_other_chip(path, spec.controller.board)
        if DIGEST not in program.symbols:
            raise Refused(
                f"{path} has no {DIGEST}: it was not built from sources of heatwright,"
                " or its symbols were removed."
            )
        check_digest(program, spec.digest)
        measured = given(path, spec.controller.board)
        Variables(program)["loop_" + next(iter(spec.controller.loops))]
    except TooLarge as error:
        raise DoesNotFit(misfit(spec, error)) from None
    except (ElfError, BuildFailed, StaleBinary) as error:
        raise Refused(str(error)) from None
    return measured
