# SPDX-License-Identifier: GPL-3.0-or-later
"""How fast it is here: `heatwright generate` from the shell, and the simulation of an example.

`make bench` runs it. It prints figures beside what the project aims at; it judges nothing, for a
busy machine is no fault of the program.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
HEATWRIGHT = Path(sys.executable).with_name("heatwright")
SPEC = ROOT / "spec" / "examples" / "chamber.yaml"


def heatwright(*words: str) -> str:
    """Run a command and return what it printed."""
    done = subprocess.run(  # noqa: S603 - our own command
        [HEATWRIGHT, *words], capture_output=True, text=True, check=True
    )
    return done.stdout


def generate_s(times: int = 10) -> float:
    """Shortest time of some, in s: what the machine does beside it can only add."""
    with tempfile.TemporaryDirectory() as folder:
        taken = []
        for number in range(times):
            start = time.perf_counter()
            heatwright("generate", str(SPEC), "-o", str(Path(folder) / str(number)))
            taken.append(time.perf_counter() - start)
    return min(taken)


def speed() -> float:
    """Simulated seconds in one second, in the closed loop that `verify` runs."""
    measured = json.loads(heatwright("verify", str(SPEC), "--json"))["speed"]
    return float(measured["simulated_s"] / measured["wall_s"])


if __name__ == "__main__":
    print(f"generate  {generate_s():8.3f} s          (aim: at most 0.3 s)")
    print(f"simulate  {speed():8.0f} × real time  (aim: at least 2000)")
