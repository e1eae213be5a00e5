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
