"""What command lines say that are run in this process, and specs for them."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from rig.specs import EXAMPLES


class Outcome(NamedTuple):
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)


Heatwright = Callable[..., Outcome]


def changed(name: str, old: str, new: str, count: int = 1) -> str:
    """Write changed.yaml, an example with some of its text replaced, and return its name."""
    text = (EXAMPLES / f"{name}.yaml").read_text("utf-8")
    assert text.count(old) >= count
    Path("changed.yaml").write_text(text.replace(old, new, count), encoding="utf-8")
    return "changed.yaml"
