"""Reads a binary that was built elsewhere, and checks that it belongs to the spec."""

from pathlib import Path

from heatwright.cli.ends import Refused
from heatwright.cli.fits import DoesNotFit, misfit
from heatwright.generator.toolchain import BuildFailed, BuildResult, TooLarge
from heatwright.generator.toolchain.given import given, refuse_other_chip
from heatwright.sim.binary.dwarf import Variables
from heatwright.sim.binary.elf import Elf, ElfError
from heatwright.sim.device import DIGEST, StaleBinary, check_digest
from heatwright.spec import Spec
from heatwright.spec.loading.user_file import read_file


def given_binary(spec: Spec, path: Path) -> BuildResult:
    """Check the binary against the spec, and measure the memory that it takes.

    Raises Refused if it is no AVR program, not for this chip or not from this spec, or if it cannot
    be verified because names or debug information are missing.
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
