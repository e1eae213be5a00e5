"""The generated HAL files in LinuxCNC's own HAL, in front of a made-up board."""

import time

import pytest
from hal_session import Hal
from made_up_board import MadeUpBoard

ROUND_S = 1 / 3.6
"""MAX_UPDATE_RATE of the generated mb2hal.ini."""
OBEYED_S = 3 * ROUND_S + 2 * 0.2
"""Three rounds and two control steps: until then ON waits for WORK."""
HEARD_S = 5.0
LATE_S = 10.0
"""What a busy machine may take on top."""

ENABLED, WORK = "fabricator-nozzle-enabled", "fabricator-nozzle-work"


def until(board: MadeUpBoard, name: str, value: object) -> None:
    end = time.monotonic() + LATE_S
    while getattr(board, name) != value:
        assert time.monotonic() < end, f"{name} is {getattr(board, name)}"
        time.sleep(0.02)


def stays_off(hal: Hal, board: MadeUpBoard) -> None:
    time.sleep(4 * ROUND_S)
    assert not board.enabled
    assert hal.signal(ENABLED) == 0


def switch_on(hal: Hal, board: MadeUpBoard) -> None:
    hal.press("fabricator-nozzle-on")
    until(board, "enabled", True)
    hal.wait(WORK, 1, LATE_S)
    assert hal.signal(ENABLED) == 1


def test_what_is_read_comes_in_units(hal: Hal, board: MadeUpBoard) -> None:
    board.duty_percent, board.amperes = 45.6, 1.78
    hal.wait("fabricator-nozzle-duty", 45.6, LATE_S)
    hal.wait("fabricator-nozzle-current", 1.78, LATE_S)
    for celsius in (-12.3, 3276.7, -3276.7, None, -0.1):
        board.celsius, board.has_measured = celsius or 0.0, celsius is not None
        hal.wait("fabricator-nozzle-temperature", celsius or -3276.8, LATE_S)
    assert hal.signal("fabricator-nozzle-valid") == 1


def test_the_setpoint_goes_out_in_tenths_rounded(hal: Hal, board: MadeUpBoard) -> None:
    until(board, "setpoint_celsius", 30.0)
    for entered, arrives in ((299.96, 300.0), (30.14, 30.1), (30.16, 30.2), (0.04, 0.0)):
        hal.set_signal("fabricator-nozzle-setpoint", entered)
        until(board, "setpoint_celsius", arrives)
    assert board.refused == []


@pytest.mark.parametrize(("entered", "arrives"), [(-5.04, -50), (1e9, 32767), (-1e9, -32768)])
def test_a_setpoint_outside_is_refused_and_none_wraps_into_the_range(
    hal: Hal, board: MadeUpBoard, entered: float, arrives: int
) -> None:
    until(board, "setpoint_celsius", 30.0)
    hal.set_signal("fabricator-nozzle-setpoint", entered)
    end = time.monotonic() + LATE_S
    while not board.refused:
        assert time.monotonic() < end
        time.sleep(0.02)
    assert set(board.refused) == {arrives & 0xFFFF}
    assert board.setpoint_celsius == 30.0
    assert hal.signal("fabricator-exchange") == 1


@pytest.mark.parametrize("slow_s", [0.0, OBEYED_S - 2 * ROUND_S])
def test_on_and_off(hal: Hal, board: MadeUpBoard, slow_s: float) -> None:
    """However long the controller takes."""
    board.slow_s = slow_s
    switch_on(hal, board)
    time.sleep(OBEYED_S)
    assert board.enabled
    assert hal.signal(ENABLED) == 1
    hal.press("fabricator-nozzle-off")
    until(board, "enabled", False)
    hal.wait(WORK, 0, LATE_S)
    assert board.refused == []


def test_a_fault_resets_the_latch_and_neither_its_acknowledgement_nor_a_held_button_sets_it(
    hal: Hal, board: MadeUpBoard
) -> None:
    switch_on(hal, board)
    hal.set_signal("fabricator-nozzle-on", 1)
    board.trip(6, 351.2)
    hal.wait("fabricator-fault", 1, LATE_S)
    hal.wait(ENABLED, 0, LATE_S)
    hal.wait("fabricator-fault-code", 6, LATE_S)
    hal.wait("fabricator-fault-temperature", 351.2, LATE_S)
    hal.press("fabricator-acknowledge")
    hal.wait("fabricator-fault", 0, LATE_S)
    stays_off(hal, board)
    assert board.oracle.acknowledged == 1
    hal.set_signal("fabricator-nozzle-on", 0)
    switch_on(hal, board)


def test_a_controller_that_restarts_stays_off(hal: Hal, board: MadeUpBoard) -> None:
    switch_on(hal, board)
    board.restart()
    hal.wait(ENABLED, 0, OBEYED_S + LATE_S)
    stays_off(hal, board)
    switch_on(hal, board)


def test_a_lost_exchange_switches_off_and_its_return_does_not_switch_on(
    hal: Hal, board: MadeUpBoard
) -> None:
    switch_on(hal, board)
    board.deaf = True
    hal.wait("fabricator-exchange", 0, HEARD_S + LATE_S)
    assert hal.signal(ENABLED) == 0
    board.deaf = False
    hal.wait("fabricator-exchange", 1, LATE_S)
    until(board, "enabled", False)
    stays_off(hal, board)


def test_the_machine_can_forbid_heat(hal: Hal, board: MadeUpBoard) -> None:
    switch_on(hal, board)
    hal.set_signal("fabricator-inhibit", 1)
    until(board, "enabled", False)
    hal.press("fabricator-nozzle-on")
    hal.set_signal("fabricator-inhibit", 0)
    stays_off(hal, board)


def test_the_firmware_of_another_spec_is_not_switched_on(hal: Hal, board: MadeUpBoard) -> None:
    board.turn_digest(1 << 16)
    hal.wait("fabricator-exchange", 0, LATE_S)
    hal.press("fabricator-nozzle-on")
    stays_off(hal, board)
    board.turn_digest(1 << 16 | 1)
    time.sleep(4 * ROUND_S)
    assert hal.signal("fabricator-exchange") == 0
