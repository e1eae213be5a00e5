import shlex
from pathlib import Path
from shutil import copy

import pytest
from rig.commands import Heatwright, Outcome
from rig.specs import EXAMPLES

from heatwright.cli.ends import ended
from heatwright.cli.main import cli


@pytest.fixture
def heatwright(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Heatwright:
    """Runs a line, which must end with a status, in a folder with chamber.yaml and oven.yaml."""
    for example in ("chamber.yaml", "oven.yaml"):
        copy(EXAMPLES / example, tmp_path)
    monkeypatch.chdir(tmp_path)

    def run(words: str, status: int = 0) -> Outcome:
        capfd.readouterr()
        found = ended(cli, shlex.split(words))
        out, err = capfd.readouterr()
        assert "Traceback" not in out + err
        assert found == status, err
        return Outcome(out, err)

    return run
