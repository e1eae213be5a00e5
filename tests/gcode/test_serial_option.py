"""`heatwright simulate --serial`, and the clock it runs by."""

import json
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from printrun_host import printrun_host
from pymodbus.client import ModbusSerialClient
from rig.specs import EXAMPLES

from heatwright.sim.live import Clock

HEATWRIGHT = Path(sys.executable).parent / "heatwright"
UNKNOWN = 0x8000
"""Of a temperature: the board has not measured yet."""


def heatwright(*arguments: str | Path) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [HEATWRIGHT, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def asked_by_printcore(port: str, baud: int) -> None:
    with printrun_host(port, baud) as host:
        host.ask("M115", "FIRMWARE_NAME:heatwright")


def asked_by_pymodbus(port: str, baud: int) -> None:
    """Tenths of a degree, within a step of the converter there, once it has measured."""
    client = ModbusSerialClient(port, baudrate=baud, timeout=1, retries=5)
    assert client.connect()
    while (tenths := client.read_input_registers(100).registers[0]) == UNKNOWN:
        pass
    assert abs(tenths - 200) <= 24
    counters = client.read_input_registers(10, count=6).registers
    assert counters[0] == counters[3]  # nobody else asks
    client.close()


@pytest.mark.parametrize(
    ("spec", "speed", "baud", "ask"), [("extruder", 20.0, 115_200, asked_by_printcore),
                                       ("fabricator", 1.0, 19_200, asked_by_pymodbus)],
    ids=["gcode", "modbus"],
)  # fmt: skip
def test_a_host_finds_the_board_until_ctrl_c(
    spec: str, speed: float, baud: int, ask: Callable[[str, int], None]
) -> None:
    options = ("--serial", "--speed", str(speed), "--json")
    with heatwright("simulate", EXAMPLES / f"{spec}.yaml", *options) as process:
        assert process.stdout is not None
        told = json.loads("".join(process.stdout.readline() for _ in range(5)))
        assert (told["baud"], told["speed"]) == (baud, speed)
        ask(told["port"], told["baud"])
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


@pytest.mark.parametrize(
    ("speed", "lost_s", "waits", "pauses"),
    [(2.0, 0.0, 3, [0.5, 0.5, 0.5]), (1.0, 10.0, 2, [1.0]), (1.0, 1.2, 2, [0.8])],
    ids=["in_time", "much_is_lost_for_good", "a_little_is_made_up_for"],
)
def test_the_clock_waits_for_the_boards_time(
    speed: float, lost_s: float, waits: int, pauses: list[float]
) -> None:
    """What was lost is not made up for in a rush."""
    now_s, paused_s = [100.0], []

    def pause(seconds: float) -> None:
        paused_s.append(seconds)
        now_s[0] += seconds

    clock = Clock(speed, lambda: now_s[0], pause)
    now_s[0] += lost_s
    for board_s in range(1, waits + 1):
        clock.wait(float(board_s))
    assert paused_s == pytest.approx(pauses)
