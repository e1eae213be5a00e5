"""The committed firmware is what its spec generates today, both ways."""

from pathlib import Path

import pytest
from rig.specs import example, files_of

from heatwright.generator import compare

ROOT = Path(__file__).parents[2]
GENERATED = ROOT / "generated"
NAMES = ("chamber", "extruder", "fabricator", "feeder", "kiln")
"""The examples whose firmware is committed."""


def committed(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("name", NAMES)
def test_the_committed_firmware_is_current(name: str) -> None:
    files = files_of(name)
    assert compare(files, GENERATED / name) == ()
    assert committed(GENERATED / name) == set(files)
    assert example(name).controller.identity.name == name


def test_nothing_else_is_committed() -> None:
    assert {path.name for path in GENERATED.iterdir()} == set(NAMES)
