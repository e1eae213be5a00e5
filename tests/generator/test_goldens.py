"""The committed firmware is what its spec generates today, both ways."""

from collections.abc import Mapping
from pathlib import Path

import pytest

from heatwright.generator import Difference, compare, plan_firmware, render
from heatwright.generator.output import left_over
from heatwright.spec import load

ROOT = Path(__file__).parents[2]
GENERATED = ROOT / "generated"
NAMES = ("chamber", "extruder", "fabricator", "feeder", "kiln")
"""The examples whose firmware is committed."""


def committed(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("name", NAMES)
def test_the_committed_firmware_is_current(name: str) -> None:
    spec = load(ROOT / "spec" / "examples" / f"{name}.yaml")
    files = render(plan_firmware(spec))
    assert compare(files, GENERATED / name) == ()
    assert committed(GENERATED / name) == set(files)
    assert spec.controller.identity.name == name


def test_nothing_else_is_committed() -> None:
    assert {path.name for path in GENERATED.iterdir()} == set(NAMES)


def test_a_drift_either_way_is_seen(tmp_path: Path, chamber_files: Mapping[str, str]) -> None:
    older = {path: text for path, text in chamber_files.items() if path != "src/text.c"}
    for path, text in chamber_files.items():
        target = tmp_path / path
        target.parent.mkdir(exist_ok=True)
        target.write_text(text, encoding="utf-8")
    assert compare(older, tmp_path) == (Difference("src/text.c", "extra"),)
    assert left_over(older, tmp_path) == ("src/text.c",)
    (tmp_path / "src" / "text.h").unlink()
    (tmp_path / "README.md").write_bytes(b"")
    assert compare(chamber_files, tmp_path) == (
        Difference("README.md", "changed"),
        Difference("src/text.h", "missing"),
    )
