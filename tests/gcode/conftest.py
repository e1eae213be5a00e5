from pathlib import Path

import pytest
from gcode_world import BinaryBoard, Board, HostBoard, celsius, gcode_world


@pytest.fixture(scope="session")
def world() -> Path:
    """The extruder's G-code as a program of this computer: see gcode_world."""
    return gcode_world().sanitized().program()


@pytest.fixture(params=["host", "binary"])
def feeder(request: pytest.FixtureRequest) -> Board:
    """The feeder at 200 °C, ready: its files on this computer, and its binary."""
    board: Board
    if request.param == "host":
        board = HostBoard(gcode_world("feeder").sanitized().program(), celsius(200))
    else:
        board = BinaryBoard("feeder", nozzle=200.0)
    assert board.told("M104 S200", 1.0) == ["ok"]
    return board
