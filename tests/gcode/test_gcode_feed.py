"""G0 and G1: lengths become steps, exactly, and none while the machine is not ready."""

import pytest

from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.spec import Controller

STEPS_PER_MM = 200 * 16 / 25
HOT_C = 200.0


@pytest.fixture
def board(feeder: Controller, feeder_program: Elf) -> AvrDevice:
    """The feeder at 200 °C, ready."""
    device = AvrDevice(feeder, feeder_program)
    device.sense("nozzle", HOT_C)
    device.advance(1.0)
    assert told(device, f"M104 S{HOT_C}", 1.0) == ["ok"]
    return device


def told(device: AvrDevice, line: str, seconds: float = 0.5) -> list[str]:
    """Send a line as a person does, and give what is answered."""
    host = device.host
    known = len(host.lines)
    host.send_bytes(line.encode() + b"\n")
    device.advance(device.time_s + seconds)
    return [each.text for each in device.host.lines[known:]]


def steps(device: AvrDevice) -> int:
    device.feed()
    return int(device.outputs["feed"].position)


def place(device: AvrDevice) -> str:
    return told(device, "M114")[0].removeprefix("X:0.00 Y:0.00 Z:0.00 ")


@pytest.mark.parametrize(
    ("lines", "length_mm"),
    [
        (["G1 E10 F600"], 10.0), (["G0E2.5"], 2.5), (["G1 X5 Y5 E1"], 1.0), (["G1 X5 F300"], 0.0),
        (["G1 E5", "G1 E8"], 8.0), (["M83", "G1 E5", "G1 E-2"], 3.0), (["G1 E5", "G1 E0"], 0.0),
        (["G1 E3", "G92 E0", "G1 E3"], 6.0), (["G92 E100", "G1 E101"], 1.0), (["G1 E-1"], -1.0),
        (["G1 E4", "G92", "G1 E1"], 5.0),
        (["G1 E4", "G92 X0", "G1 E1"], 1.0),
    ],
)  # fmt: skip
def test_lengths(board: AvrDevice, lines: list[str], length_mm: float) -> None:
    for line in lines:
        assert told(board, line, 3.0)[-1] == "ok"
    assert steps(board) == round(length_mm * STEPS_PER_MM)
    assert board.outputs["feed"].violations == 0
    assert board.outputs["feed"].missed == 0


def test_distances_lose_nothing_by_rounding(board: AvrDevice) -> None:
    """A thousand times a third of a step."""
    told(board, "M83")
    for _ in range(300):
        told(board, f"G1 E{1 / STEPS_PER_MM / 3:.6f}", 0.05)
    board.advance(board.time_s + 1.0)
    assert steps(board) == pytest.approx(100, abs=1)


def test_it_says_where_it_is(board: AvrDevice) -> None:
    told(board, "G1 E12.5 F1200", 3.0)
    assert place(board) == "E:12.50"
    told(board, "G92 E3")
    assert place(board) == "E:3.00"


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("G1 Ex", "needs a number; nothing was changed"),
        ("G1 E1 Fx", "needs a number; nothing was changed"),
        ("G1 E1 F0", "is outside its limits; nothing was changed"),
        ("G1 E9999999", "is outside its limits; nothing was changed"),
        ("G1 E99999999", "needs a number; nothing was changed"),
    ],
)
def test_what_is_refused_moves_nothing(board: AvrDevice, line: str, reason: str) -> None:
    assert told(board, line, 1.0) == [f"Error:G1 {reason}", "ok"]
    assert steps(board) == 0


def test_no_feed_while_the_heater_is_off(board: AvrDevice) -> None:
    told(board, "M104 S0")
    assert told(board, "G1 E5") == ["Error:G1 refused: the heater is off", "ok"]
    assert steps(board) == 0


def test_it_waits_until_the_machine_is_ready(board: AvrDevice) -> None:
    """The first move is taken and waits in the feed; the next one waits with its ok."""
    told(board, "M104 S203")
    assert told(board, "G1 E5") == ["ok"]
    assert told(board, "G1 E-1", 5.0) == ["echo:busy: processing"] * 2
    assert steps(board) == 0
    board.sense("nozzle", 203.0)
    board.advance(board.time_s + 3.0)
    assert steps(board) == round(-1 * STEPS_PER_MM)
    assert board.host.lines[-1].text == "ok"


def test_m108_lets_go_of_what_waits(board: AvrDevice) -> None:
    told(board, "M104 S203")
    told(board, "G1 E5")
    told(board, "G1 E-1", 1.0)
    assert told(board, "M108", 0.2) == ["ok", "ok"]


def test_m400_waits_for_the_end(board: AvrDevice) -> None:
    assert told(board, "G1 E20 F600", 0.1) == ["ok"]
    assert "ok" not in told(board, "M400", 1.5)
    board.advance(board.time_s + 1.0)
    assert board.host.lines[-1].text == "ok"
    assert steps(board) == round(20 * STEPS_PER_MM)


def test_m410_ends_a_move_and_the_next_begins_where_it_stands(board: AvrDevice) -> None:
    told(board, "G1 E50 F1200", 1.0)
    told(board, "G1 E80", 0.2)
    told(board, "M410\nG92 E0\nG1 E1", 3.0)
    stopped = steps(board)
    assert 10 * STEPS_PER_MM < stopped < 45 * STEPS_PER_MM
    assert place(board) == "E:1.00"
    told(board, "G1 E3", 2.0)
    assert steps(board) == stopped + round(2 * STEPS_PER_MM)


def test_a_stop_ends_the_move_for_good(board: AvrDevice) -> None:
    told(board, "G1 E50 F1200", 1.0)
    told(board, "M112", 1.0)
    stopped = steps(board)
    assert told(board, "G1 E5") == ["Error:G1 refused: acknowledge the fault with M999", "ok"]
    told(board, "M999")
    told(board, f"M104 S{HOT_C}", 3.0)
    assert steps(board) == stopped
    assert place(board) == f"E:{stopped / STEPS_PER_MM:.2f}"


def test_off_forgets_the_move(board: AvrDevice) -> None:
    told(board, "G1 E50 F1200", 1.0)
    told(board, "M104 S0", 2.0)
    stopped = steps(board)
    told(board, f"M104 S{HOT_C}", 3.0)
    assert steps(board) == stopped


def test_a_tuning_forgets_the_move(board: AvrDevice) -> None:
    """It ends with the loop off: what was left must not go on with the next target."""
    told(board, "G1 E50 F600", 1.0)
    told(board, f"M303 S{HOT_C}", 1.0)
    told(board, "M108", 1.0)
    before = steps(board)
    assert 0 < before < 50 * STEPS_PER_MM
    told(board, f"M104 S{HOT_C}", 3.0)
    assert steps(board) == before


def test_m84_lets_the_motor_go_after_the_last_move(board: AvrDevice) -> None:
    told(board, "G1 E10 F600", 0.1)
    assert told(board, "M84", 2.0)[-1] == "ok"
    assert steps(board) == round(10 * STEPS_PER_MM)
    board.on_fraction("feed")
    board.advance(board.time_s + 1.0)
    assert board.on_fraction("feed") == 0.0


def test_a_stream_of_moves_does_not_run_away(board: AvrDevice) -> None:
    """A host that sends as fast as it hears ok is a second ahead, no more."""
    told(board, "M83")
    for _ in range(100):
        board.send("G1 E1 F600")
    board.advance(board.time_s + 5.0)
    sent = len(board.host.sent)
    done_mm = steps(board) / STEPS_PER_MM
    assert 40 < done_mm <= 50
    assert sent - 1 - done_mm <= 10 + 3
    board.advance(board.time_s + 7.0)
    assert steps(board) == round(100 * STEPS_PER_MM)
