"""Every kind of heatwright's own has all that a kind needs, and few ask of which kind a thing is.

What the rest of the program needs to know of a kind, the kind says (a property, or a constant of
its class): then mypy lists what a new one lacks. To ask for a kind is left to the kind's own files,
whose path has one of the words of its name. All that a kind needs is there by the rule for
packages.
"""

import ast
import json
import os
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from rig.firmware import ROOT, finished

from heatwright.cli.contract import UNIONS, lacking
from heatwright.spec import Algorithm, Interface, Output, Sensor, kinds
from heatwright.spec.registry import KindIncomplete, module_of
from heatwright.spec.sensing.analog_parts import AnalogSensor

ASKED = 15
"""Places that ask elsewhere: whoever takes one away lowers it."""
READ = 30
"""Files that read a loop's period; `Loop` says what follows from it, as `periods_s`."""
CLASSES = {
    model.__name__: kind
    for union in (Sensor, Output, Algorithm, Interface)
    for kind, model in kinds(union).items()
} | {AnalogSensor.__name__: "analog"}


def asked_in(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield the line and the kind of each question."""
    for node in ast.walk(tree):
        match node:
            case ast.Call(func=ast.Name("isinstance"), args=[_, classes]):
                names = [each.id for each in ast.walk(classes) if isinstance(each, ast.Name)]
                yield from ((node.lineno, CLASSES[name]) for name in names if name in CLASSES)
            case ast.MatchClass(cls=ast.Name(name)) if name in CLASSES:
                yield node.lineno, CLASSES[name]
            case ast.Compare(left=left, comparators=[*others]):
                parts = [left, *others]
                if any(isinstance(each, ast.Attribute) and each.attr == "kind" for each in parts):
                    inner = (each for part in parts for each in ast.walk(part))
                    strings = {each.value for each in inner if isinstance(each, ast.Constant)}
                    yield from ((node.lineno, kind) for kind in CLASSES.values() if kind in strings)


def is_own(path: str, kind: str) -> bool:
    words = {word.removesuffix("s") for word in re.split(r"\W|_", path)}
    return not words.isdisjoint(kind.split("_"))


def test_kinds_are_asked_for_in_their_own_files() -> None:
    found = {
        (path.relative_to(ROOT).as_posix(), line)
        for folder in ("spec", "generator", "sim", "cli")
        for path in (ROOT / folder).rglob("*.py")
        for line, kind in asked_in(ast.parse(path.read_text("utf-8")))
        if not is_own(path.relative_to(ROOT).as_posix(), kind)
    }
    assert len(found) == ASKED, sorted(found)


def test_what_follows_from_a_period_is_said_once() -> None:
    found = [
        path.relative_to(ROOT).as_posix()
        for folder in ("spec", "generator", "templates", "sim", "cli")
        for path in (ROOT / folder).rglob("*")
        if path.suffix in {".py", ".j2"} and ".period_s" in path.read_text("utf-8")
    ]
    assert len(found) <= READ, sorted(found)


OUTSIDE = sorted(each.parent for each in (ROOT / "examples").glob("*/pyproject.toml"))


@pytest.mark.parametrize(
    ("role", "kind"), [(role, kind) for role, union in UNIONS.items() for kind in kinds(union)]
)
def test_nothing_is_missing(role: str, kind: str) -> None:
    assert list(lacking(role, kind)) == []


def test_a_module_that_is_missing_is_named() -> None:
    with pytest.raises(KindIncomplete, match=r"write .*/reference/sensors/spoon\.py, which"):
        module_of("sensor", "reference", "spoon")
    told = "pyproject.toml: no entry point sensor.spoon in heatwright.kinds that is installed"
    assert list(lacking("sensor", "spoon")) == [told]


@pytest.mark.parametrize("folder", OUTSIDE, ids=lambda each: each.name)
def test_a_package_among_the_examples_is_whole(folder: Path, tmp_path: Path) -> None:
    """As if it were installed; tests/packaging does so."""
    points = tomllib.loads((folder / "pyproject.toml").read_text("utf-8"))["project"]
    ((group, named),) = points["entry-points"].items()
    lines = [f"[{group}]", *(f"{name} = {place}" for name, place in named.items())]
    (tmp_path / "outside-1.dist-info").mkdir()
    (tmp_path / "outside-1.dist-info" / "entry_points.txt").write_text("\n".join(lines))
    paths = os.pathsep.join(map(str, (tmp_path, folder)))
    words = [sys.executable, "-m", "heatwright.cli.start", "kinds", "--json"]
    env = {**os.environ, "PYTHONPATH": paths}
    told = finished(words, env=env)
    assert told.returncode == 0, told.stdout + told.stderr
    found = {f"{each['role']}.{each['kind']}": each for each in json.loads(told.stdout)["kinds"]}
    assert set(named) <= set(found)
    assert all(found[name]["package"] == f"heatwright_{folder.name}" for name in named)
