from pathlib import Path
from shutil import copy

import pytest
from rig.commands import Heatwright, run
from rig.specs import EXAMPLES


@pytest.fixture
def heatwright(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Heatwright:
    """Runs a line, which must end with a status, in a folder with chamber.yaml and oven.yaml."""
    for example in ("chamber.yaml", "oven.yaml"):
        copy(EXAMPLES / example, tmp_path)
    monkeypatch.chdir(tmp_path)
    return lambda words, status=0: run(capfd, words, status)
