"""A real OctoPrint with its default settings, and the simulated board behind a pseudo-terminal."""

import json
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from http.client import HTTPException
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

import pytest
from rig.firmware import ROOT
from rig.live import Cable, LiveBoard, live_board
from suite import amount

PROGRAM = ROOT / "build" / "judges" / "octoprint" / "bin" / "octoprint"
PATIENCE_S = 600.0
"""Real time after which something is not going to happen."""
GLANCE_S = 0.25
KEY = "0123456789abcdef0123456789abcdef"
CALLS_HOME = [
    "achievements", "announcements", "backup", "discovery", "errortracking", "health_check",
    "pluginmanager", "softwareupdate", "tracking",
]  # fmt: skip
CONFIG = {
    "server": {
        "firstRun": False,
        "onlineCheck": {"enabled": False},
        "pluginBlacklist": {"enabled": False},
    },
    "api": {"key": KEY},
    "serial": {"additionalPorts": ["/dev/pts/*"]},
    "gcodeAnalysis": {"runAt": "never"},
    "plugins": {"_disabled": CALLS_HOME},
}
"""As after the first run; it stays off the network and takes no time for estimates."""

MACHINE = "printer"
TARGETS_C = {"tool0": 200.0, "bed": 60.0}
MONITOR, MONITOR_C = "drivers", (15.0, 60.0)
DAMAGED = 0.005
"""Of the bytes, both ways: about one line in ten is hit."""
CABLE = Cable(115200, speed=20.0, to_board_share=DAMAGED, to_host_share=DAMAGED, spares=b"Resend")
"""A number that is damaged in a `Resend: 12` can end a print with any firmware: OctoPrint ends it
where it no longer knows that line. So these arrive whole."""
LAYERS = range(1, 101)
PRINTS = ("first.gcode", "second.gcode")
LINES = [
    "M140 S60",
    "M104 S200",
    "M190 S60",
    "M109 S200",
    *(
        line
        for number in LAYERS
        for line in (f"M301 D{number}", "M106 S255", f"G1 X20.25 Y{number} E1.5 F1800")
    ),
    "M502",
    "M104 S0",
    "M140 S0",
    "M107",
]
"""`M301` is answered with the gains: which layers were printed."""


class OctoPrint:
    """The server, by its REST interface; home -- its folder."""

    def __init__(self, home: Path) -> None:
        with socket.create_server(("127.0.0.1", 0)) as free:
            self._port = free.getsockname()[1]
        self._log = home / "logs" / "octoprint.log"
        home.joinpath("config.yaml").write_text(json.dumps(CONFIG), "utf-8")
        where = ["--host", "127.0.0.1", "--port", str(self._port), "--basedir", str(home)]
        self._process = subprocess.Popen(
            [PROGRAM, "serve", "--iknowwhatimdoing", *where],  # also as root, as in a container
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.wait(self._is_up)

    def close(self) -> None:
        self._process.kill()
        self._process.wait()

    def _is_up(self) -> bool:
        assert self._process.poll() is None
        try:
            return bool(self.state)
        except (HTTPException, OSError):  # nobody answers, or one who asks to wait
            return False

    def wait(self, done: Callable[[], bool]) -> None:
        """Wait until something has happened."""
        end = time.monotonic() + PATIENCE_S
        while not done():
            assert time.monotonic() < end, self._log.read_text("utf-8")[-2000:]
            time.sleep(GLANCE_S)

    def ask(self, path: str, body: dict[str, Any] | None = None) -> Any:
        """Get a resource, or post to it."""
        data = None if body is None else json.dumps(body).encode()
        return self._ask(path, data, "application/json")

    def _ask(self, path: str, data: bytes | None, kind: str) -> Any:
        headers = {"X-Api-Key": KEY, "Content-Type": kind}
        address = f"http://127.0.0.1:{self._port}/api/{path}"
        with urlopen(Request(address, data, headers), timeout=PATIENCE_S) as answer:
            return json.loads(answer.read() or "null")

    def upload(self, name: str, lines: list[str]) -> None:
        head = f'Content-Disposition: form-data; name="file"; filename="{name}"'
        body = "\r\n".join(["--part", head, "", *lines, "--part--", ""])
        self._ask("files/local", body.encode(), "multipart/form-data; boundary=part")

    @property
    def state(self) -> str:
        return str(self.ask("connection")["current"]["state"])

    def connect(self, port: str) -> None:
        self.ask("connection", {"command": "connect", "port": port, "baudrate": CABLE.baud})
        self.wait(lambda: self.state == "Operational")

    def disconnect(self) -> None:
        self.ask("connection", {"command": "disconnect"})
        self.wait(lambda: self.is_offline)

    @property
    def is_offline(self) -> bool:
        return self.state.startswith(("Closed", "Error", "Offline"))

    def heat(self) -> None:
        """Set all targets, and wait until it sees them reached."""
        for heater, target in TARGETS_C.items():
            body = {"target": target} if heater == "bed" else {"targets": {heater: target}}
            self.ask(f"printer/{heater.rstrip('0')}", {"command": "target", **body})
        self.wait(self._is_hot)

    def _is_hot(self) -> bool:
        felt = self.ask("printer")["temperature"]
        return all(
            heater in felt and abs(felt[heater]["actual"] - target) < 3.0
            for heater, target in TARGETS_C.items()
        )

    def send(self, line: str) -> None:
        self.ask("printer/command", {"command": line})

    def print(self, name: str) -> None:
        """Print a file to its end; another one than the last, whose end it remembers."""
        self.ask(f"files/local/{name}", {"command": "select", "print": True})
        self.wait(lambda: self._has_printed(name) or self.is_offline)
        assert self._has_printed(name), self.ask("job")

    def _has_printed(self, name: str) -> bool:
        job = self.ask("job")
        file, done = job["job"]["file"]["name"], job["progress"]["completion"]
        return (job["state"], file, done) == ("Operational", name, 100.0)


@pytest.fixture(scope="module")
def octoprint(tmp_path_factory: pytest.TempPathFactory) -> Iterator[OctoPrint]:
    if not PROGRAM.is_file():
        pytest.skip("OctoPrint is missing: make setup EVIDENCE=1")
    server = OctoPrint(tmp_path_factory.mktemp("octoprint"))
    try:
        for name in PRINTS:
            server.upload(name, LINES)
        yield server
    finally:
        server.close()


def layers(said: list[str]) -> list[float]:
    return [float(line.split()[5][1:]) for line in said if line.startswith("echo:  M301")]


def printed(octoprint: OctoPrint, board: LiveBoard, name: str) -> None:
    """Print; every line is done, once, and in order, though the cable damages bytes."""
    hits, before = board.ask("hits"), layers(board.ask("said"))
    board.ask("noise")
    octoprint.print(name)
    board.ask("quiet")
    assert board.ask("hits") > hits + 20
    assert layers(board.ask("said")) == [*before, *LAYERS]
    assert board.ask("fault.code") == 0


@pytest.mark.parametrize("seed", range(amount("octoprint_seeds")))
def test_it_prints_is_refused_meets_a_fault_and_goes_on(octoprint: OctoPrint, seed: int) -> None:
    first, second = PRINTS
    with live_board(MACHINE, replace(CABLE, seed=seed)) as board:
        board.ask("quiet")
        octoprint.connect(board.port)
        octoprint.heat()
        felt = octoprint.ask("printer")["temperature"][MONITOR]
        assert MONITOR_C[0] < felt["actual"] < MONITOR_C[1]
        printed(octoprint, board, first)

        for refused in ("M104 S400", "G1 E5 F60", "M140 S400"):
            octoprint.send(refused)
        octoprint.wait(lambda: any("outside its limits" in line for line in board.ask("said")))
        octoprint.heat()  # it is still there

        board.ask("torn")
        octoprint.wait(lambda: octoprint.is_offline)
        assert "SENSOR OPEN" in octoprint.ask("job")["error"]
        board.ask("sound")
        octoprint.connect(board.port)
        octoprint.send("M104 S200")
        octoprint.wait(lambda: any("acknowledge the fault" in line for line in board.ask("said")))
        octoprint.send("M999")
        octoprint.wait(lambda: board.ask("fault.code") == 0)
        octoprint.heat()
        printed(octoprint, board, second)
        octoprint.disconnect()
