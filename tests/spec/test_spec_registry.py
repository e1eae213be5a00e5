"""Every kind of heatwright's own has all that a kind needs, by the rule for packages."""

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from heatwright.cli.contract import UNIONS, lacking
from heatwright.spec import kinds
from heatwright.spec.registry import KindIncomplete, module_of

OUTSIDE = Path(__file__).parents[2] / "examples" / "max31865"


@pytest.mark.parametrize(
    ("role", "kind"), [(role, kind) for role, union in UNIONS.items() for kind in kinds(union)]
)
def test_nothing_is_missing(role: str, kind: str) -> None:
    assert list(lacking(role, kind)) == []


def test_a_module_that_is_missing_is_named() -> None:
    with pytest.raises(KindIncomplete, match=r"write .*/reference/sensors/spoon\.py, which"):
        module_of("sensor", "reference", "spoon")
    assert list(lacking("sensor", "spoon")) == [
        "pyproject.toml: no entry point sensor.spoon in heatwright.kinds that is installed"
    ]


def test_the_package_among_the_examples_is_whole(tmp_path: Path) -> None:
    """As if it were installed; tests/packaging does so."""
    points = tomllib.loads((OUTSIDE / "pyproject.toml").read_text("utf-8"))["project"]
    ((group, named),) = points["entry-points"].items()
    lines = [f"[{group}]", *(f"{name} = {place}" for name, place in named.items())]
    (tmp_path / "outside-1.dist-info").mkdir()
    (tmp_path / "outside-1.dist-info" / "entry_points.txt").write_text("\n".join(lines))
    paths = os.pathsep.join(map(str, (tmp_path, OUTSIDE)))
    words = [sys.executable, "-m", "heatwright.cli.start", "kinds", "--json"]
    env = {**os.environ, "PYTHONPATH": paths}
    told = subprocess.run(words, env=env, capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stdout + told.stderr
    found = {f"{each['role']}.{each['kind']}": each for each in json.loads(told.stdout)["kinds"]}
    assert set(named) <= set(found)
    assert all(found[name]["package"] == "heatwright_max31865" for name in named)
