"""The generated C against MISRA C:2012, by cppcheck's addon; `misra.toml` has what deviates."""

import re
import shutil
import tomllib
from pathlib import Path

from rig.firmware import EXAMPLE_NAMES, controller_of, files_of, finished
from suite import amount

from heatwright.generator import write

DEVIATIONS = tomllib.loads(Path(__file__).with_name("misra.toml").read_text("utf-8"))


def broken(name: str, folder: Path) -> set[str]:
    """Return the rules that an example's firmware breaks."""
    write(files_of(name), folder)
    board = controller_of(name).board
    words = "cppcheck --quiet --enable=style --addon=misra --std=c11 --platform=avr8 --library=avr"
    macros = (f"-D{board.macro}", f"-DF_CPU={board.clock_hz}UL")
    done = finished([*words.split(), *macros, "--template={id}", "src"], cwd=folder, check=True)
    assert "Error" not in done.stderr
    return set(re.findall(r"^misra-c2012-([\d.]+)$", done.stderr, re.MULTILINE))


def test_no_rule_is_broken_without_a_reason(tmp_path: Path) -> None:
    assert shutil.which("cppcheck"), "sudo apt-get install cppcheck"
    names = EXAMPLE_NAMES[: amount("misra_examples")]
    found = {name: broken(name, tmp_path / name) for name in names}
    for name, rules in found.items():
        assert rules <= DEVIATIONS.keys(), name
    if names == EXAMPLE_NAMES:
        assert set().union(*found.values()) == DEVIATIONS.keys()
