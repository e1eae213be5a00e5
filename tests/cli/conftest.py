from pathlib import Path
from shutil import copyfile

import pytest
from rig.commands import Heatwright, Outcome, run
from rig.specs import EXAMPLES


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

    def line(words: str, status: int = 0) -> Outcome:
        return run(capfd, words, status)

    return line
