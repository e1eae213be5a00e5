"""`heatwright bench` as a user starts it."""

import json
import signal
import socket
import subprocess
from pathlib import Path
from typing import Any
from urllib.request import urlopen

from rig.commands import changed
from rig.live import HEATWRIGHT


def test_it_serves_until_ctrl_c(heatwright: Any) -> None:
    command = [HEATWRIGHT, "bench", "chamber.yaml", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        told = json.loads("".join(process.stdout.readline() for _ in range(3)))
        with urlopen(told["address"], timeout=60) as page:  # noqa: S310 - the address is ours
            assert "<title>Bench</title>" in page.read().decode()
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == 0


def test_a_port_that_is_taken_is_told(heatwright: Any) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        found = heatwright(f"bench chamber.yaml --port {port}", status=2)
    assert f"Port {port} cannot be opened" in found.err
    assert "Leave out --port" in found.err


def test_without_a_machine_there_is_nothing_to_run(heatwright: Any) -> None:
    text = Path("chamber.yaml").read_text("utf-8")
    name = changed("chamber", text[text.index("\nsimulation:") :], "\n")
    assert "the spec has no `simulation`" in heatwright(f"bench {name}", status=2).err


def test_verify_takes_what_was_done(heatwright: Any) -> None:
    scenario = 'scenario:\n  - {at: 5.00 s, press: "up"}\n  - {for: 60.00 s}\n'
    Path("done.yaml").write_text(scenario, "utf-8")
    found = heatwright("verify chamber.yaml --scenario done.yaml --json").json
    assert found["passed"]
    Path("done.yaml").write_text("scenario:\n  - {at: 5.00 s, send: M105}\n  - {for: 60.00 s}\n")
    assert "done.yaml:2" in heatwright("verify chamber.yaml --scenario done.yaml", status=2).err
