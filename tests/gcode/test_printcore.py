"""Printrun's printcore, as it is, and the simulated board behind a pseudo-terminal, of the
tests' or of `heatwright simulate --serial`."""

import re
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from printrun.gcoder import LightGCode
from printrun.printcore import printcore
from rig.firmware import EXAMPLES
from rig.live import HEATWRIGHT, Cable, LiveBoard, live_board, simulated

from heatwright.sim.live import Clock

PATIENCE_S = 120.0
"""Real time after which something is not going to happen."""
GLANCE_S = 0.01
WRITING_STEPS = 5
"""0.5 s of the board's own time: a record of 48 bytes is written within 0.25 s."""


class PrintrunHost:
    """heard -- all lines; temperatures -- those that printcore took for temperatures; errors."""

    def __init__(self, core: Any) -> None:
        self.core = core
        self.heard: list[str] = []
        self.temperatures: list[str] = []
        self.errors: list[str] = []
        core.recvcb = lambda line: self.heard.append(line.rstrip())
        core.tempcb = lambda line: self.temperatures.append(line.rstrip())
        core.errorcb = lambda line: self.errors.append(str(line).rstrip())

    def print(self, lines: list[str]) -> None:
        """Send lines as a print is sent, numbered and with checksums; wait for the end."""
        assert self.core.startprint(LightGCode(lines))
        self.wait(lambda: not self.core.printing)
        self.wait(self._listens_again)

    def _listens_again(self) -> bool:
        """Whether printcore has left its printing for its sending thread: it ends badly between."""
        core = self.core
        return (
            core.print_thread is None
            and core.send_thread is not None
            and core.send_thread.is_alive()
        )

    def ask(self, line: str, answer: str) -> str:
        """Send a line beside any print; wait for an answer that begins so."""
        known = len(self.heard)
        self.core.send_now(line)
        self.wait(lambda: any(text.startswith(answer) for text in self.heard[known:]))
        return next(text for text in self.heard[known:] if text.startswith(answer))

    def wait(self, done: Callable[[], bool]) -> None:
        """Wait until something has happened."""
        end = time.monotonic() + PATIENCE_S
        while not done():
            assert time.monotonic() < end, self.heard[-10:]
            time.sleep(GLANCE_S)


@contextmanager
def printrun_host(port: str, baud: int) -> Iterator[PrintrunHost]:
    """Connect printcore to a port."""
    core = printcore()
    host = PrintrunHost(core)
    core.connect(port, baud)
    try:
        host.wait(lambda: core.online)
        yield host
    finally:
        core.disconnect()


CABLE = Cable(115200, speed=50.0)
TEMPERATURE = re.compile(r"T:(\d+\.\d) /(\d+\.\d) B:0\.0 /0\.0 @:(\d+)")
NOISE = 0.004
"""Of the bytes, both ways: about one line in ten is hit."""


@pytest.fixture
def board() -> Iterator[LiveBoard]:
    with live_board("extruder", CABLE) as live:
        yield live


@pytest.fixture
def host(board: LiveBoard) -> Iterator[PrintrunHost]:
    with printrun_host(board.port, CABLE.baud) as connected:
        yield connected


def temperature_c(line: str) -> float:
    found = TEMPERATURE.search(line)
    assert found is not None, line
    return float(found[1])


def test_it_connects_and_reads_temperatures(host: PrintrunHost, board: LiveBoard) -> None:
    host.wait(lambda: bool(board.ask("loop_nozzle.has_reading")))  # its first tenth of a second
    host.ask("M105", "ok T:")
    assert temperature_c(host.temperatures[-1]) == pytest.approx(20.0, abs=0.5)
    assert host.ask("M115", "FIRMWARE_NAME").startswith("FIRMWARE_NAME:heatwright spec ")
    assert host.errors == []


def test_it_heats_with_m109_and_goes_on(host: PrintrunHost, board: LiveBoard) -> None:
    host.print(["M105", "M109 S200", "M105", "M104 S0"])
    waited = [temperature_c(line) for line in host.heard if " W:" in line]
    assert waited[0] < 30.0
    assert abs(waited[-1] - 200.0) <= 1.0
    assert len(waited) > 30
    assert "echo:busy: processing" in host.heard
    assert temperature_c(host.temperatures[-1]) == pytest.approx(200.0, abs=1.0)
    assert host.errors == []
    assert board.ask("settings.nozzle_setpoint_c") == 0.0


def test_it_tunes_stores_and_shows(host: PrintrunHost, board: LiveBoard) -> None:
    host.print(["M303 E0 S200 C5", "M500", "M503"])
    assert "PID Autotune finished! The gains are in use and stored." in host.heard
    assert sum(line.startswith("bias: ") for line in host.heard) == 4
    gains = [board.ask(f"settings.nozzle_{gain}") for gain in ("kp", "ki", "kd")]
    found = next(line for line in host.heard if line.startswith("Kp: "))
    assert [float(text) for text in found.split()[1::2]] == pytest.approx(gains, abs=1e-5)
    assert gains == [board.ask(f"autotune_nozzle.{gain}") for gain in ("kp", "ki", "kd")]
    held = 100 * (200 - 20) / 14.7 / 40  # % that the plant's losses take
    proposed = next(line for line in host.heard if line.startswith("Integral: "))
    least, most = (float(text) for text in re.findall(r"[\d.]+", proposed))
    assert (least, most) == (23.5, pytest.approx(1.5 * held, rel=0.05))  # 12 below is the spec's
    told = len(board.ask("steps"))
    host.wait(lambda: len(board.ask("steps")) > told + WRITING_STEPS)
    known = len(host.heard)
    board.ask("cut")
    host.wait(lambda: "start" in host.heard[known:])  # what is sent while it starts is lost
    host.ask("M503", "echo:  M301 E0 P")
    assert gains == [board.ask(f"settings.nozzle_{gain}") for gain in ("kp", "ki", "kd")]
    assert host.errors == []


def test_it_hears_of_a_stop(host: PrintrunHost, board: LiveBoard) -> None:
    host.ask("M104 S200", "ok")
    host.ask("M112", "Error:E19")
    assert board.ask("fault.code") == 19
    host.wait(lambda: host.errors != [])
    assert host.errors[0].startswith("Error:E19 STOPPED")
    host.ask("M999", "ok")
    assert board.ask("fault.code") == 0


@pytest.mark.parametrize("seed", range(4))
def test_it_survives_a_storm_of_resends(seed: int) -> None:
    """Every line is done, once, and in order, though the cable damages bytes both ways."""
    cable = replace(CABLE, to_board_share=NOISE, to_host_share=NOISE, seed=seed)
    lines = [f"M301 P{number}" for number in range(1, 151)]
    with live_board("extruder", cable) as board:
        with printrun_host(board.port, CABLE.baud) as host:
            host.print(lines)
        said = board.ask("said")
        steps = board.ask("steps")
        assert board.ask("hits") > 20
        assert sum(line.startswith("Resend: ") for line in said) > 3
        done = [line.split()[3] for line in said if line.startswith("echo:  M301")]
        assert done == [f"P{number}.00000" for number in range(1, 151)]
        assert board.ask("settings.nozzle_kp") == 150.0
        assert np.array_equal(np.diff(steps["steps"].astype(int)), np.ones(len(steps) - 1))


def test_a_host_finds_the_board_until_ctrl_c() -> None:
    with simulated("extruder", 20.0) as (port, baud), printrun_host(port, baud) as host:
        assert baud == 115_200
        host.ask("M115", "FIRMWARE_NAME:heatwright")


def test_it_ends_by_itself_when_told() -> None:
    arguments = ("--serial", "--speed", "100", "--for", "20 s")
    command = [HEATWRIGHT, "simulate", EXAMPLES / "feeder.yaml", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.startswith("/dev/")
    assert "115200 baud, 100 times real time. Ctrl-C ends it." in done.stdout


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
