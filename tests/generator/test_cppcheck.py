"""A second opinion on the generated C: cppcheck finds nothing."""

import shutil
import subprocess
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from random import Random

import pytest
from rig.controllers import drawings
from suite import SEED, amount

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.plan.assembly import MCU_MACROS
from heatwright.spec import load_text

CPPCHECK = [
    "cppcheck", "--quiet", "--enable=warning,performance,portability", "--inconclusive",
    "--std=c11", "--platform=avr8", "--library=avr", "--error-exitcode=1",
]  # fmt: skip


def check(texts: Mapping[str, str], folder: Path, macro: str, clock_hz: int) -> None:
    write(texts, folder)
    assert shutil.which("cppcheck"), "sudo apt-get install cppcheck"
    done = subprocess.run(
        [*CPPCHECK, f"-D{macro}", f"-DF_CPU={clock_hz}UL", "src"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")


def test_nothing_is_found_in_the_chamber(tmp_path: Path, chamber_files: Mapping[str, str]) -> None:
    check(chamber_files, tmp_path, "__AVR_ATmega328P__", 16_000_000)


@pytest.mark.parametrize("name", ["fabricator", "dryer", "kiln", "kiln_uno"])
def test_nothing_is_found_in_other_examples(name: str, tmp_path: Path) -> None:
    text = files("heatwright.spec.examples").joinpath(f"{name}.yaml").read_text(encoding="utf-8")
    spec = load_text(text, f"{name}.yaml")
    board = spec.controller.board
    check(render(plan_firmware(spec)), tmp_path, MCU_MACROS[board.mcu], board.clock_hz)


@pytest.mark.parametrize("number", range(amount("drawn_for_cppcheck")))
def test_nothing_is_found_in_what_is_drawn(number: int, tmp_path: Path) -> None:
    random = Random(f"cppcheck {SEED} {number}")  # noqa: S311 - no secret
    spec = next(iter(drawings(random))).spec
    board = spec.controller.board
    check(render(plan_firmware(spec)), tmp_path, MCU_MACROS[board.mcu], board.clock_hz)
