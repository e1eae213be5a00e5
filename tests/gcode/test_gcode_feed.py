"""G0 and G1: lengths become steps, exactly, and none while the machine is not ready."""

import pytest
from gcode_world import BinaryBoard, Board, HostBoard, celsius, gcode_world, ready

STEPS_PER_MM = 200 * 16 / 25
HOT = "M104 S200"


@pytest.fixture(params=["host", "binary"])
def feeder(request: pytest.FixtureRequest) -> Board:
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
        ("G1F600E2", 2.0), ("G1 E0.003|G1 E0.001", 0.0), ("M83|G1 E-2 F30|G1 E3 F1200", 1.0),
        ("G1 E20 F240|M500", 20.0), ("G1 E12 F240|M104 S200", 12.0), ("G1 E0 F1", 0.0),
        ("G1 E5|G1 E5", 5.0), ("G1 E5|M400|G1 E6", 6.0), ("G1 E5|M84|G1 E6", 6.0),
    ],
)  # fmt: skip
def test_lengths(feeder: Board, lines: str, length_mm: float) -> None:
    for line in lines.split("|"):
        answers = feeder.told(line, 3.0)
        assert answers[-1] == "ok"
        assert set(answers) <= {"ok", "echo:busy: processing", "echo:Settings Stored"}
    assert feeder.steps == round(length_mm * STEPS_PER_MM)
    if isinstance(feeder, BinaryBoard):
        assert feeder.device.outputs["feed"].violations == 0
        assert feeder.device.outputs["feed"].missed == 0


@pytest.mark.parametrize(
    ("speed", "mm_per_s"),
    [("F600", 10), ("F120", 2), ("", 20), ("F9999", 20), ("F1230", 20), ("F1170", 19.5)],
)
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
        ("G1 E7812500", "is outside its limits"), ("G1 E-7812500", "is outside its limits"),
        ("G92 E9999999", "needs a number"),
    ],
)  # fmt: skip
def test_what_is_refused_moves_nothing(feeder: Board, line: str, reason: str) -> None:
    command = line.split(maxsplit=1)[0]
    assert feeder.told(line, 1.0) == [f"echo:{command} {reason}; nothing was changed", "ok"]
    assert feeder.steps == 0


@pytest.mark.parametrize(
    ("lines", "taken"),
    [
        ("G1 E1.99 F120|G1 E3", True), ("G1 E2 F120|G1 E3", False), ("G1 E7812499", True),
        ("M83|G1 E-0.0078 F1|G1 E-0.0078", True), ("G1 E-20 F600|G1 E-20", True),
        ("M83|G1 E20 F600|G1 E0", True),
    ],
)  # fmt: skip
def test_what_is_taken_at_once(feeder: Board, lines: str, taken: bool) -> None:
    """What goes on the same way, and that of which nothing is left, while nothing moves yet."""
    feeder.tell("M104 S203")
    *first, last = lines.split("|")
    assert [answer for line in first for answer in feeder.told(line, 0.1)] == len(first) * ["ok"]
    assert feeder.told(last, 0.3) == taken * ["ok"]


@pytest.mark.parametrize("waits", ["G1 E-1", "M400", "M84|M400"])
def test_m108_and_m410_end_a_wait_of_the_feed_at_once(feeder: Board, waits: str) -> None:
    """And with it what waited; M108 leaves the moves, M410 the motor. The heater stays on."""
    for ends, least_mm in (("M108", 49), ("M410", 1)):
        for line in waits.split("|")[:-1]:
            feeder.tell(line)
        feeder.tell("M83\nG1 E50 F600", 1.0)
        begun = feeder.steps
        assert feeder.told(waits.rsplit("|", maxsplit=1)[-1], 0.1) == []
        assert feeder.told(ends, 0.1) == ["ok", "ok"]
        assert feeder.told("M400", 6.0)[-1:] == ["ok"]
        assert least_mm - 11 < (feeder.steps - begun) / STEPS_PER_MM < least_mm + 11
        assert not feeder.motor_is_free
    assert " /200.0 " in feeder.told("M105")[0]


def test_a_host_need_not_speak_while_its_moves_go_on() -> None:
    feeder = HostBoard(gcode_world("feeder").sanitized().program(), celsius(200))
    ready(feeder).tell("M83\nG1 E20 F600", 1.5)
    assert int(feeder.said().state["silent"]) == 0
    feeder.wait(2.0)
    assert 50 < int(feeder.said().state["silent"]) <= 150


def test_what_m410_is_not(feeder: Board) -> None:
    assert feeder.told("G1 E20 F600\nM40:\nM9999\nG28\nM82", 0.2) == [
        "ok", *(part for line in ("M40", "M9999", "G28")
                for part in (f'echo:Unknown command: "{line}"', "ok")), "ok"]  # fmt: skip
    feeder.wait(3.0)
    assert feeder.steps == round(20 * STEPS_PER_MM)
    assert not feeder.motor_is_free


@pytest.mark.parametrize(
    ("ends", "reason"),
    [("M104 S0", "the heater is off"), ("M112", "acknowledge the fault with M999")],
)
def test_no_feed_while_nothing_heats(feeder: Board, ends: str, reason: str) -> None:
    feeder.tell(ends, 1.0)
    assert feeder.told("G1 E5") == [f"echo:G1 refused: {reason}", "ok"]
    feeder.tell("M999")
    feeder.tell(HOT, 3.0)
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


def test_m410_ends_a_move_and_the_next_begins_where_it_stands(feeder: Board) -> None:
    feeder.tell("G1 E50 F1200", 1.0)
    feeder.tell("G1 E80", 0.2)
    feeder.tell("M 410\nG92 E0\nG1 E1", 3.0)
    stopped = feeder.steps
    assert 10 * STEPS_PER_MM < stopped < 45 * STEPS_PER_MM
    assert place(feeder) == "E:1.00"
    assert feeder.told("G1 E3 F120\nG1 E4", 0.2) == ["ok", "ok"]
    feeder.wait(3.0)
    assert feeder.steps == stopped + round(3 * STEPS_PER_MM)


@pytest.mark.parametrize("ends", ["M104 S0", "M303 S200|M108", "M112|M999"])
def test_off_a_tuning_and_a_stop_forget_the_move(feeder: Board, ends: str) -> None:
    """What was left must not go on with the next target."""
    feeder.tell("G1 E50 F1200", 1.0)
    for line in ends.split("|"):
        feeder.tell(line, 1.0)
    stopped = feeder.steps
    assert 0 < stopped < 50 * STEPS_PER_MM
    feeder.tell(HOT, 3.0)
    assert feeder.steps == stopped
    assert place(feeder) == f"E:{stopped / STEPS_PER_MM:.2f}"


@pytest.mark.parametrize("line", ["M84", "M18"])
def test_the_motor_is_let_go_after_the_last_move(feeder: Board, line: str) -> None:
    feeder.tell("G1 E10 F600", 0.1)
    assert feeder.told(line, 2.0)[-1] == "ok"
    assert feeder.steps == round(10 * STEPS_PER_MM)
    assert feeder.motor_is_free
