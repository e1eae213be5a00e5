"""What command lines say that are run in this process, and specs for them."""

import json
import shlex
from collections.abc import Callable
from pathlib import Path
from shutil import copy
from typing import Any, NamedTuple

import pytest
from rig.firmware import EXAMPLES

from heatwright.cli.ends import ended
from heatwright.cli.main import cli


class Outcome(NamedTuple):
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


def changed(name: str, old: str, new: str, count: int = 1) -> str:
    """Write changed.yaml, an example with some of its text replaced, and return its name."""
    text = (EXAMPLES / f"{name}.yaml").read_text("utf-8")
    assert text.count(old) >= count
    Path("changed.yaml").write_text(text.replace(old, new, count), encoding="utf-8")
    return "changed.yaml"


def printer_rows() -> str:
    """Write rows.yaml, the printer with a row to compare for each of its loops; return its name."""
    rows = """comparison:
  - {name: PI, loop: bed, setpoint: 60 °C, algorithm: {kind: pid, kp: 10, ki: 0.05, band: 10 K}}
  - name: relay
    loop: hotend
    setpoint: 200 °C
    algorithm: {kind: on_off}
    output: {kind: digital, pin: D10, power: 40 W}
"""
    text = (EXAMPLES / "printer.yaml").read_text("utf-8")
    Path("rows.yaml").write_text(text + rows, encoding="utf-8")
    return "rows.yaml"
