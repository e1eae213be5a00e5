"""G0 and G1: lengths become steps, exactly, and none while the machine is not ready."""

import pytest
from gcode_world import BinaryBoard, Board, HostBoard, celsius, gcode_world, ready

STEPS_PER_MM = 200 * 16 / 25
HOT = "M104 S200"


@pytest.fixture(params=["host", "binary"])
def feeder(request: pytest.FixtureRequest) -> Board:
    """The feeder at 200 °C, ready: its files on this computer, and its binary."""
    if request.param == "binary":
        return ready(BinaryBoard("feeder", nozzle=200.0))
    return ready(HostBoard(gcode_world("feeder").sanitized().program(), celsius(200)))


def place(board: Board) -> str:
    return board.told("M114")[0].removeprefix("X:0.00 Y:0.00 Z:0.00 ")


@pytest.mark.parametrize(
    ("lines", "length_mm"),
    [
        ("G1 E10 F600", 10.0), ("G0E2.5", 2.5), ("G1 X5 Y5 E1", 1.0), ("G1 X5 F300", 0.0),
        ("G1 E5|G1 E8", 8.0), ("M83|G1 E5|G1 E-2", 3.0), ("G1 E5|G1 E0", 0.0),
        ("G1 E3|G92 E0|G1 E3", 6.0), ("G92 E100|G1 E101", 1.0), ("G1 E-1", -1.0),
        ("G1 E4|G92|G1 E1", 5.0), ("G1 E4|G92 X0|G1 E1", 1.0), ("G1 E4|G92 Y0|G1 E1", 1.0),
        ("G1 E4|G92 Z0|G1 E1", 1.0), ("M83|G1 E2|M82|G1 E5", 5.0),
        ("M83|G1 E0.003|G1 E0.003|G1 E0.003", 1 / STEPS_PER_MM),
        *((f"M83|G1 E0.003|{forgets}|G1 E0.001", 0.0) for forgets in ("M83", "G92 E0", "M410")),
        ("G1 E0.0043", 1 / STEPS_PER_MM), ("G1 E-0.0043", -1 / STEPS_PER_MM), ("G1 E-0.0035", 0.0),
        ("G1 E5|G1 E5", 5.0), ("G1 E5|M400|G1 E6", 6.0), ("G1 E5|M84|G1 E6", 6.0),
    ],
)  # fmt: skip
def test_lengths(feeder: Board, lines: str, length_mm: float) -> None:
    for line in lines.split("|"):
        answers = feeder.told(line, 3.0)
        assert answers[-1] == "ok"
        assert not any(answer.startswith("Error") for answer in answers)
    assert feeder.steps == round(length_mm * STEPS_PER_MM)
    if isinstance(feeder, BinaryBoard):
        assert feeder.device.outputs["feed"].violations == 0
        assert feeder.device.outputs["feed"].missed == 0


@pytest.mark.parametrize(("speed", "mm_per_s"), [("F600", 10), ("F120", 2), ("F9999", 20)])
def test_speeds(feeder: Board, speed: str, mm_per_s: float) -> None:
    """Kept for the lines that name none, and no faster than the feed may run."""
    feeder.tell(f"G1 {speed}")
    feeder.tell("M83")
    feeder.tell("G1 E100", 0.5)
    begun = feeder.steps
    feeder.wait(4.0)
    assert (feeder.steps - begun) / STEPS_PER_MM == pytest.approx(4 * mm_per_s, rel=0.01)


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("G1 Ex", "needs a number"), ("G1 E1 Fx", "needs a number"), ("G92 Ex", "needs a number"),
        ("G1 E99999999", "needs a number"), ("G1 E1 F0", "is outside its limits"),
        ("G1 E9999999", "is outside its limits"), ("G1 E-9999999", "is outside its limits"),
    ],
)  # fmt: skip
def test_what_is_refused_moves_nothing(feeder: Board, line: str, reason: str) -> None:
    command = line.split(maxsplit=1)[0]
    assert feeder.told(line, 1.0) == [f"Error:{command} {reason}; nothing was changed", "ok"]
    assert feeder.steps == 0


@pytest.mark.parametrize(("line", "ahead"), [("G1 E1 F600", 10), ("G1 E-1 F600", 10),
                                             ("G1 E1 F300", 5)])  # fmt: skip
def test_a_host_that_does_not_wait_is_a_second_ahead(feeder: Board, line: str, ahead: int) -> None:
    """Further moves the same way are taken while less than a second of them is left."""
    answers = feeder.told("\n".join(["M83", *[line] * 18]), 0.5)
    done_mm = abs(feeder.steps) / STEPS_PER_MM
    assert 0.1 * ahead < done_mm < ahead
    assert answers.count("ok") - 1 == pytest.approx(ahead + done_mm, abs=1)
    feeder.wait(5.0)
    assert abs(feeder.steps) == 18 * STEPS_PER_MM


def test_no_feed_while_the_heater_is_off(feeder: Board) -> None:
    feeder.tell("M104 S0")
    assert feeder.told("G1 E5") == ["Error:G1 refused: the heater is off", "ok"]
    assert feeder.steps == 0


def test_it_waits_until_the_machine_is_ready(feeder: Board) -> None:
    """The first move is taken and waits in the feed; the next one waits with its ok."""
    feeder.tell("M104 S203")
    assert feeder.told("G1 E5") == ["ok"]
    assert feeder.told("G1 E-1", 5.0) == ["echo:busy: processing"] * 2
    assert feeder.steps == 0
    feeder.sense("nozzle", 203.0)
    feeder.wait(3.0)
    assert feeder.steps == round(-1 * STEPS_PER_MM)
    assert feeder.heard()[-1] == "ok"


def test_m400_waits_for_the_end(feeder: Board) -> None:
    assert feeder.told("G1 E20 F600", 0.1) == ["ok"]
    assert "ok" not in feeder.told("M400", 1.5)
    feeder.wait(1.0)
    assert feeder.heard()[-1] == "ok"
    assert feeder.steps == round(20 * STEPS_PER_MM)
    assert not feeder.motor_is_free


def test_m410_ends_a_move_and_the_next_begins_where_it_stands(feeder: Board) -> None:
    feeder.tell("G1 E50 F1200", 1.0)
    feeder.tell("G1 E80", 0.2)
    feeder.tell("M410\nG92 E0\nG1 E1", 3.0)
    stopped = feeder.steps
    assert 10 * STEPS_PER_MM < stopped < 45 * STEPS_PER_MM
    assert place(feeder) == "E:1.00"
    feeder.tell("G1 E3", 2.0)
    assert feeder.steps == stopped + round(2 * STEPS_PER_MM)


@pytest.mark.parametrize("line", ["M410", "M 410"])
def test_m410_as_it_comes_in_and_as_a_line(feeder: Board, line: str) -> None:
    """The receiver recognises the one, and even a wait for the end is over; not the other."""
    feeder.tell("G1 E20 F600", 0.1)
    assert feeder.told("M400", 0.2) == []
    assert feeder.told(line, 0.5) == ["ok", "ok"] * (line == "M410")
    feeder.tell("M108", 3.0)
    assert 0 < feeder.steps < 15 * STEPS_PER_MM


def test_a_stop_ends_the_move_for_good(feeder: Board) -> None:
    feeder.tell("G1 E50 F1200", 1.0)
    feeder.tell("M112", 1.0)
    stopped = feeder.steps
    assert feeder.told("G1 E5") == ["Error:G1 refused: acknowledge the fault with M999", "ok"]
    feeder.tell("M999")
    feeder.tell(HOT, 3.0)
    assert feeder.steps == stopped
    assert place(feeder) == f"E:{stopped / STEPS_PER_MM:.2f}"


@pytest.mark.parametrize("ends", ["M104 S0", "M303 S200|M108"])
def test_off_and_a_tuning_forget_the_move(feeder: Board, ends: str) -> None:
    """What was left must not go on with the next target."""
    feeder.tell("G1 E50 F1200", 1.0)
    for line in ends.split("|"):
        feeder.tell(line, 1.0)
    stopped = feeder.steps
    assert 0 < stopped < 50 * STEPS_PER_MM
    feeder.tell(HOT, 3.0)
    assert feeder.steps == stopped


@pytest.mark.parametrize("line", ["M84", "M18"])
def test_the_motor_is_let_go_after_the_last_move(feeder: Board, line: str) -> None:
    feeder.tell("G1 E10 F600", 0.1)
    assert feeder.told(line, 2.0)[-1] == "ok"
    assert feeder.steps == round(10 * STEPS_PER_MM)
    assert feeder.motor_is_free
