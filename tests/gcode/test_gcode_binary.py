"""The binary behind its serial line: nothing that arrives costs a tick, a byte or a limit."""

import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.interfaces.gcode import GcodeHost
from heatwright.sim.serial_noise import SerialNoise
from heatwright.spec import Controller

BAUD = 115200
TICK_S = 0.01
STOPPED = "Error:E19 STOPPED (M112): heaters are off until M999"
WAKE_UP = b"\nM108\nM104 S0\nM999\nM155 S0\n"


@pytest.fixture
def board(extruder: Controller, extruder_program: Elf) -> AvrDevice:
    device = AvrDevice(extruder, extruder_program)
    device.sense("nozzle", 20.0)
    device.advance(1.0)
    return device


def run(device: AvrDevice, seconds: float) -> GcodeHost:
    device.advance(device.time_s + seconds)
    return device.host


def told(device: AvrDevice, line: str, seconds: float = 0.5) -> list[str]:
    """Send a line as a person does, and give what is answered."""
    host = device.host
    known = len(host.lines)
    host.send_bytes(line.encode() + b"\n")
    return [each.text for each in run(device, seconds).lines[known:]]


def is_in_time(device: AvrDevice) -> bool:
    """Every step came within a tick of its time, and none was left out."""
    log = device.steps("nozzle")
    due_s = log["time_s"][0] + 0.1 * (log["steps"] - log["steps"][0]).astype(float)
    no_gap = np.array_equal(np.diff(log["steps"].astype(int)), np.ones(len(log) - 1))
    return bool(no_gap) and bool(np.abs(log["time_s"] - due_s).max() < TICK_S)


def test_it_greets_and_answers(board: AvrDevice) -> None:
    assert [line.text[:18] for line in board.host.lines] == ["start", "echo:heatwright ex"]
    board.send("M105")
    assert run(board, 1.0).lines[-1].text.startswith("ok T:20.")


def test_a_host_that_waits_for_each_ok_is_answered_within_two_ticks(board: AvrDevice) -> None:
    host = board.host
    host.send_bytes(b"M105\n")
    sent_s = board.time_s + 5 * 10 / BAUD
    answer = run(board, 0.5).lines[-1]
    bytes_s = 10 / BAUD * (len(answer.text) + 1)
    assert answer.time_s < sent_s + 2 * TICK_S + bytes_s


@pytest.mark.parametrize(
    "flood",
    [
        b"M105\n" * 20_000,
        b"M503\nM115\n" * 10_000,
        b"\n" * 100_000,
        b"\x00" * 100_000,
        b"x" * 100_000,
        b"N1 M104 S200*1\n" * 7_000,
        random.Random(1).randbytes(100_000),  # noqa: S311 - noise, the same in every run
    ],
    ids=["M105", "M503", "empty", "zeros", "endless", "resends", "noise"],
)
def test_a_flood_costs_no_step(board: AvrDevice, flood: bytes) -> None:
    board.host.send_bytes(flood)
    run(board, 9.0)
    assert board.avr.uarts[0].overruns == 0
    assert board.read("fault.code") == 0
    assert is_in_time(board)
    run(board, 2.0)
    assert told(board, "\nM105")[-1].startswith("ok T:")


@given(st.binary(min_size=1, max_size=2000))
@settings(max_examples=30)
def test_any_bytes_cost_no_step(extruder: Controller, extruder_program: Elf, data: bytes) -> None:
    board = AvrDevice(extruder, extruder_program)
    board.sense("nozzle", 20.0)
    board.host.send_bytes(data)
    run(board, 3.0)
    assert is_in_time(board)
    board.host.send_bytes(WAKE_UP)
    run(board, 3.0)
    assert told(board, "M105")[-1].startswith("ok T:")
    assert 0.0 <= board.read("settings.nozzle_setpoint_c") <= 260.0


@pytest.mark.parametrize("flooded", [False, True])
def test_m112_has_the_heater_off_within_two_ticks(board: AvrDevice, flooded: bool) -> None:
    """While it waits for the heat, and however many lines wait before it."""
    told(board, "M109 S200", 3.0)
    board.on_fraction("heater")
    run(board, 1.0)
    assert board.on_fraction("heater") > 0.9
    if flooded:
        board.host.send_bytes(b"M105 \n" * 500)
        run(board, 0.3)
    board.avr.uarts[0].unsend()
    board.host.send_bytes(b"\nM112\n")
    run(board, 6 * 10 / BAUD + 2 * TICK_S)
    board.on_fraction("heater")
    host = run(board, 2.0)
    assert board.on_fraction("heater") == 0.0
    assert host.texts("Error:E19 ") == [STOPPED]


def test_an_m999_sent_before_an_m112_does_not_undo_it(board: AvrDevice) -> None:
    """Lines that wait behind an M109 are done after the M112 that ends it."""
    told(board, "M109 S200", 3.0)
    board.host.send_bytes(b"M999\nM109 S210\n")
    run(board, 0.5)
    told(board, "M112", 1.0)
    board.on_fraction("heater")
    host = run(board, 2.0)
    assert board.on_fraction("heater") == 0.0
    assert board.read("fault.code") == 19
    assert host.texts("Error:M999") == ["Error:M999 refused: M112 came after it"]
    assert told(board, "M999") == ["ok"]
    assert board.read("fault.code") == 0


def test_an_acknowledged_stop_leaves_it_off(board: AvrDevice) -> None:
    told(board, "M104 S200", 5.0)
    told(board, "M112")
    assert told(board, "M104 S200") == [
        "Error:M104 refused: acknowledge the fault with M999", "ok"
    ]  # fmt: skip
    assert told(board, "M999") == ["ok"]
    board.on_fraction("heater")
    run(board, 5.0)
    assert board.on_fraction("heater") == 0.0
    assert told(board, "M105")[0].startswith("ok T:2")
    assert " /0.0 B" in told(board, "M105")[0]


def test_not_even_a_rest_of_a_period_is_heated_after_an_acknowledgement(board: AvrDevice) -> None:
    """M112 and M999 between two steps: the duty of the step before must not come back."""
    told(board, "M104 S200", 5.0)
    steps = board.read("loop_nozzle.steps")
    while board.read("loop_nozzle.steps") == steps:
        run(board, 0.001)
    board.host.send_bytes(b"M112\n")
    run(board, 3 * TICK_S)
    board.on_fraction("heater")
    board.host.send_bytes(b"M999\n")
    run(board, 4 * TICK_S)
    assert board.read("fault.code") == 0
    assert board.read("loop_nozzle.steps") == steps + 1
    assert board.on_fraction("heater") == 0.0
    told(board, "M104 S200")
    assert board.on_fraction("heater") > 0.0


def test_a_stop_is_still_latched_after_the_power_was_off(board: AvrDevice) -> None:
    told(board, "M112", 2.0)
    board.power_cycle()
    board.sense("nozzle", 20.0)
    assert run(board, 1.0).texts("Error") == [
        "Error:E19 STOPPED (M112): heaters are off until M999"
    ]


def test_gains_are_kept_when_told_so(board: AvrDevice) -> None:
    told(board, "M301 P11 I0.5 D60")
    told(board, "M500", 2.0)
    told(board, "M301 P12", 2.0)
    board.power_cycle()
    board.sense("nozzle", 20.0)
    run(board, 1.0)
    shown = "echo:  M301 E0 P11.00000 I0.50000 D60.00000"
    assert told(board, "M503")[0] == shown
    assert told(board, "M502\nM503")[-2] == "echo:  M301 E0 P9.41000 I0.34500 D31.40000"
    assert told(board, "M501\nM503")[-2] == shown


def test_the_fan_runs_as_told(board: AvrDevice) -> None:
    told(board, "M106 S64")
    board.on_fraction("part_fan")
    run(board, 2.0)
    assert board.on_fraction("part_fan") == pytest.approx(64 / 255, abs=0.01)


def test_a_bad_cable_loses_no_line(extruder: Controller, extruder_program: Elf) -> None:
    """Lines are done once and in order, whatever the cable does to bytes both ways."""
    for seed in range(3):
        board = AvrDevice(extruder, extruder_program)
        board.sense("nozzle", 20.0)
        run(board, 1.0)
        host = board.host
        host.noise = SerialNoise(to_board_share=0.005, to_host_share=0.0, seed=seed)
        for number in range(1, 101):
            host.send(f"M301 P{number}")
        run(board, 120.0)
        host.noise = None
        assert host.resends > 5
        done = [text.split()[3] for text in host.texts("echo:  M301")]
        assert done == [f"P{number}.00000" for number in range(1, 101)]
