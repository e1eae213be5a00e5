"""The generated panel in LinuxCNC's own pyvcp, on a screen that nobody sees."""

import os
import shutil
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from hal_session import Hal
from made_up_board import MadeUpBoard

LATE_S = 10.0
FINGER = "pressed_pyvcp.py"


@pytest.fixture
def display(linuxcnc: None) -> Iterator[str]:
    if shutil.which("Xvfb") is None:
        pytest.skip("Xvfb is not installed: make setup LINUXCNC=1")
    told, tell = os.pipe()
    screen = ("-screen", "0", "800x600x24", "-ac", "-nolisten", "tcp")
    command = ["Xvfb", "-displayfd", str(tell), *screen]
    with subprocess.Popen(command, pass_fds=[tell], stderr=subprocess.DEVNULL) as server:
        os.close(tell)
        try:
            yield ":" + os.read(told, 20).decode().strip()
        finally:
            os.close(told)
            server.terminate()


@pytest.fixture
def hal(display: str, board: MadeUpBoard, place: Path) -> Iterator[Hal]:
    """HAL and panel as `halrun fabricator_alone.hal` loads them, with a finger on the panel."""
    shutil.copy(Path(__file__).with_name(FINGER), place)
    panel = place / "fabricator_panel.hal"
    text = panel.read_text()
    loaded = "loadusr -Wn fabricator-panel pyvcp "
    assert loaded in text
    panel.write_text(
        text.replace(loaded, f"loadusr -Wn fabricator-panel /usr/bin/python3 {FINGER} ")
    )
    (place / "finger").write_text("")
    with Hal(place, "fabricator_alone.hal", display) as session:
        session.wait("fabricator-exchange", 1)
        yield session


def finger(place: Path, *orders: str) -> None:
    with (place / "finger").open("a") as file:
        file.writelines(f"{order}\n" for order in orders)


def press(place: Path, text: str) -> None:
    finger(place, f"press {text}")
    time.sleep(0.2)
    finger(place, f"release {text}")


def test_every_pin_of_the_panel_has_its_signal(hal: Hal) -> None:
    pins = [
        line for line in hal.command("show", "pin", "fabricator-panel").splitlines()
        if "fabricator-panel." in line
    ]  # fmt: skip
    assert len(pins) == 17
    assert all("==>" in pin or "<==" in pin for pin in pins), "\n".join(pins)


def test_the_panel_heats_stops_and_acknowledges(hal: Hal, board: MadeUpBoard, place: Path) -> None:
    hal.wait("fabricator-nozzle-setpoint", 30, LATE_S)
    finger(place, "type 300")
    hal.wait("fabricator-nozzle-setpoint", 300, LATE_S)
    press(place, "ON")
    hal.wait("fabricator-nozzle-heat", 1, LATE_S)
    assert board.setpoint_celsius == 300
    assert hal.pin("fabricator-panel.nozzle.heat") == 1
    board.celsius = 299.5
    hal.wait("fabricator-nozzle-warm", 1, LATE_S)
    assert hal.pin("fabricator-panel.nozzle.bar") == 299.5
    assert hal.pin("fabricator-panel.nozzle.temperature") == 299.5
    press(place, "OFF")
    hal.wait("fabricator-nozzle-work", 0, LATE_S)
    assert not board.enabled
    board.trip(6, 351.2)
    hal.wait("fabricator-fault", 1, LATE_S)
    press(place, "ACKNOWLEDGE")
    hal.wait("fabricator-fault", 0, LATE_S)
    assert board.oracle.acknowledged == 1


def test_a_setpoint_above_the_range_is_entered_as_its_end(hal: Hal, place: Path) -> None:
    finger(place, "type 400")
    hal.wait("fabricator-nozzle-setpoint", 320, LATE_S)
