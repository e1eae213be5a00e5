"""`heatwright simulate --serial`, and the clock it runs by."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from printrun_host import printrun_host

from heatwright.sim.live import Clock

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "spec" / "examples"
HEATWRIGHT = Path(sys.executable).parent / "heatwright"


def heatwright(*arguments: str | Path) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [HEATWRIGHT, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def test_a_host_finds_the_board_until_ctrl_c() -> None:
    extruder = EXAMPLES / "extruder.yaml"
    with heatwright("simulate", extruder, "--serial", "--speed", "20", "--json") as process:
        assert process.stdout is not None
        told = json.loads("".join(process.stdout.readline() for _ in range(5)))
        assert (told["baud"], told["speed"]) == (115200, 20.0)
        with printrun_host(told["port"], told["baud"]) as host:
            host.ask("M115", "FIRMWARE_NAME:heatwright")
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=20) == 0
    assert not Path(told["port"]).exists()


def test_it_ends_by_itself_when_told() -> None:
    arguments = ("--serial", "--speed", "100", "--for", "20 s")
    with heatwright("simulate", EXAMPLES / "feeder.yaml", *arguments) as process:
        out, _ = process.communicate(timeout=60)
    assert process.returncode == 0
    assert out.startswith("/dev/")
    assert "115200 baud, 100 times real time. Ctrl-C ends it." in out


@pytest.mark.parametrize(
    ("spec", "options", "reason"),
    [
        ("chamber.yaml", [], "No interface of this spec listens to a serial port"),
        ("extruder.yaml", ["--model"], "--serial goes with --speed, --for and --json only."),
        ("extruder.yaml", ["--csv", "x.csv"], "--serial goes with --speed, --for and --json only."),
    ],
)
def test_what_does_not_go_together(spec: str, options: list[str], reason: str) -> None:
    with heatwright("simulate", EXAMPLES / spec, "--serial", *options) as process:
        _, error = process.communicate(timeout=20)
    assert process.returncode == 2
    assert reason in error


class Wall:
    """A clock on the wall that moves when it is waited for, or by hand."""

    def __init__(self) -> None:
        self.now = 100.0
        self.pauses: list[float] = []

    def time(self) -> float:
        return self.now

    def pause(self, seconds: float) -> None:
        self.pauses.append(seconds)
        self.now += seconds


def test_the_clock_waits_for_the_board_s_time() -> None:
    wall = Wall()
    clock = Clock(2.0, wall.time, wall.pause)
    for board_s in (1.0, 2.0, 3.0):
        clock.wait(board_s)
    assert wall.pauses == pytest.approx([0.5, 0.5, 0.5])


def test_what_was_lost_is_not_made_up_for_in_a_rush() -> None:
    wall = Wall()
    clock = Clock(1.0, wall.time, wall.pause)
    wall.now += 10.0
    clock.wait(1.0)
    clock.wait(2.0)
    assert wall.pauses == pytest.approx([1.0])


def test_a_little_lost_is_made_up_for() -> None:
    wall = Wall()
    clock = Clock(1.0, wall.time, wall.pause)
    wall.now += 1.2
    clock.wait(1.0)
    clock.wait(2.0)
    assert wall.pauses == pytest.approx([0.8])
