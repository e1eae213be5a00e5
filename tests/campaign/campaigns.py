"""Small campaigns: an example with a short scenario, and what varies."""

import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rig.firmware import EXAMPLES

VARY = """\
capacities: {all: ± 20 %, walls: normal 5 %}
resistances: {air-walls: 0.15 K/W .. 0.2 K/W}
ambient: [15 °C, 20 °C, 25 °C]
supply: ± 10 %
errors: {air: ± 0.5 K}
noise: {air: 0 K .. 0.2 K}
late: 0 s .. 5 s
asks:
  - {loop: air, at: 20 s .. 25 s, setpoint: 30 °C .. 60 °C, chance: 50 %}
upsets:
  - {at: 30 s, node: air, by: -5 K .. -2 K}
  - {at: 35 s, power_cut: 1 s .. 2 s, chance: 50 %}
faults: {chance: 40 %, at: 20 s .. 30 s}
"""


def short_chamber(length: str = "1 min") -> str:
    """Write short.yaml, the chamber with a short scenario, and vary.yaml; return what to type."""
    text = (EXAMPLES / "chamber.yaml").read_text("utf-8")
    assert text.count("for: 30 min") == 1
    Path("short.yaml").write_text(text.replace("for: 30 min", f"for: {length}"), encoding="utf-8")
    Path("vary.yaml").write_text(VARY, encoding="utf-8")
    return "campaign short.yaml --vary vary.yaml"


def kept(folder: str) -> int:
    file = Path(folder, "runs.jsonl")
    return file.read_bytes().count(b"\n") if file.is_file() else 0


def wait_for(condition: Callable[[], object], what: str, of: subprocess.Popen[Any]) -> None:
    """Wait until something is so, as long as a process is there, for four minutes at most."""
    end_s = time.monotonic() + 240
    while not condition():
        assert of.poll() is None, f"{what}: it has ended"
        assert time.monotonic() < end_s, what
        time.sleep(0.05)
