"""Printrun's printcore, as it is, and the simulated board behind a pseudo-terminal."""

import re
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from printrun_host import PrintrunHost, printrun_host
from rig.live import Cable, LiveBoard, live_board

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
    board.ask("cut")
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
