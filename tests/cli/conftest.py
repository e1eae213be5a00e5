import json
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from shutil import copyfile
from typing import Any

import pytest

from heatwright.cli.ends import ended
from heatwright.cli.main import cli

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"


@dataclass
class Outcome:
    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)


Heatwright = Callable[..., Outcome]


@pytest.fixture
def heatwright(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Heatwright:
    """Runs a command line in an empty folder that holds chamber.yaml and oven.yaml.

    It must end with the given status.
    """
    for example in ("chamber.yaml", "oven.yaml"):
        copyfile(EXAMPLES / example, tmp_path / example)
    monkeypatch.chdir(tmp_path)

    def run(words: str, status: int = 0) -> Outcome:
        capfd.readouterr()
        found = ended(cli, shlex.split(words))
        out, err = capfd.readouterr()
        assert "Traceback" not in out + err
        assert found == status, err
        return Outcome(found, out, err)

    return run


def changed(name: str, old: str, new: str, count: int = 1) -> str:
    """Write changed.yaml, an example with some of its text replaced, and return its name."""
    text = (EXAMPLES / f"{name}.yaml").read_text("utf-8")
    assert text.count(old) >= count
    Path("changed.yaml").write_text(text.replace(old, new, count), encoding="utf-8")
    return "changed.yaml"
