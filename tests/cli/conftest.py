import json
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
    """Runs a command in an empty folder that holds chamber.yaml and oven.yaml."""
    for example in ("chamber.yaml", "oven.yaml"):
        copyfile(EXAMPLES / example, tmp_path / example)
    monkeypatch.chdir(tmp_path)

    def run(*words: object) -> Outcome:
        capfd.readouterr()
        status = ended(cli, [str(word) for word in words])
        out, err = capfd.readouterr()
        assert "Traceback" not in out + err
        return Outcome(status, out, err)

    return run
