"""pyserial reads the log of the kiln behind `simulate --serial`, as docs/serial_log.md shows."""

import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
HEATWRIGHT = Path(sys.executable).parent / "heatwright"
SPEED = 60
"""Times real time: an entry a minute comes every second."""


def test_the_page_s_example_reads_it() -> None:
    page = (ROOT / "docs" / "serial_log.md").read_text("utf-8")
    found = re.search(r"```python\n(.*?)```", page, re.DOTALL)
    assert found is not None
    spec = ROOT / "spec" / "examples" / "kiln_uno.yaml"
    command = [HEATWRIGHT, "simulate", spec, "--serial", "--speed", str(SPEED), "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        told = json.loads("".join(process.stdout.readline() for _ in range(5)))
        example = found[1].replace("/dev/ttyUSB0", told["port"])
        names: dict[str, Any] = {}
        for _ in range(30):
            time.sleep(1.0)
            exec(example.replace("115200", str(told["baud"])), names)  # noqa: S102 - our own page
            if len(names["rows"]) > 2:
                break
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=20) == 0
    rows = names["rows"]
    assert rows[0] == "time_s,temperature_c,setpoint_c"
    assert all(re.fullmatch(r"\d+,\d+\.\d,\d+\.\d", row) for row in rows[1:])
