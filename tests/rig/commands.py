"""Command lines, run in this process: what they say, and how they end."""

import json
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from rig.specs import EXAMPLES

from heatwright.cli.ends import ended
from heatwright.cli.main import cli


@dataclass
class Outcome:
    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)


Heatwright = Callable[..., Outcome]


def run(capfd: pytest.CaptureFixture[str], words: str, status: int) -> Outcome:
    """Run a command line, which must end with this status."""
    capfd.readouterr()
    found = ended(cli, shlex.split(words))
    out, err = capfd.readouterr()
    assert "Traceback" not in out + err
    assert found == status, err
    return Outcome(found, out, err)


def changed(name: str, old: str, new: str, count: int = 1) -> str:
    """Write changed.yaml, an example with some of its text replaced, and return its name."""
    text = (EXAMPLES / f"{name}.yaml").read_text("utf-8")
    assert text.count(old) >= count
    Path("changed.yaml").write_text(text.replace(old, new, count), encoding="utf-8")
    return "changed.yaml"
