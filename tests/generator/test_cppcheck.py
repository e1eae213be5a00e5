"""A second opinion on the generated C: cppcheck finds nothing."""

import shutil
import subprocess
from pathlib import Path
from random import Random

import pytest
from rig.controllers import drawings
from rig.specs import example
from suite import SEED, amount

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.plan.assembly import MCU_MACROS
from heatwright.spec import Spec

CPPCHECK = [
    "cppcheck", "--quiet", "--enable=warning,performance,portability", "--inconclusive",
    "--std=c11", "--platform=avr8", "--library=avr", "--error-exitcode=1",
]  # fmt: skip


def assert_nothing_is_found(spec: Spec, folder: Path) -> None:
    board = spec.controller.board
    write(render(plan_firmware(spec)), folder)
    assert shutil.which("cppcheck"), "sudo apt-get install cppcheck"
    done = subprocess.run(
        [*CPPCHECK, f"-D{MCU_MACROS[board.mcu]}", f"-DF_CPU={board.clock_hz}UL", "src"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("name", ["chamber", "fabricator", "dryer", "kiln", "kiln_uno"])
def test_nothing_is_found_in_examples(name: str, tmp_path: Path) -> None:
    assert_nothing_is_found(example(name), tmp_path)


@pytest.mark.parametrize("number", range(amount("drawn_for_cppcheck")))
def test_nothing_is_found_in_what_is_drawn(number: int, tmp_path: Path) -> None:
    random = Random(f"cppcheck {SEED} {number}")  # noqa: S311 - no secret
    assert_nothing_is_found(next(iter(drawings(random))).spec, tmp_path)
