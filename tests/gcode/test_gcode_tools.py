"""Several tools on one line, and loops without gains."""

import re
from pathlib import Path

import pytest
from gcode_world import BinaryBoard, Board, HostBoard, celsius, gcode_world, switched, tuning_ends

CURVE = "divider: {pull_up: 4.7 kΩ}, curve: {resistance: 100 kΩ, at: 25 °C, beta: 4267 K}"
SPEC = f"""heatwright: 1
controller: {{name: pair, board: uno}}
sensors:
  nozzle: {{kind: thermistor, pin: A0, {CURVE}, range: 0 °C .. 300 °C}}
  bed: {{kind: thermistor, pin: A1, {CURVE}, range: 0 °C .. 300 °C}}
outputs:
  nozzle: {{kind: pwm, pin: D9, frequency: 100 Hz, power: 40 W}}
  bed: {{kind: digital, pin: D4, power: 100 W}}
loops:
  nozzle:
    {{sensor: nozzle, heater: nozzle, period: 100 ms, autotune: {{}},
     algorithm: {{kind: pid, kp: 5, ki: 0.1, kd: 10}},
     setpoint: {{initial: 0 °C, minimum: 10 °C, maximum: 250 °C}},
     protection: {{maximum: 280 °C, minimum: 5 °C, rise_rate: 20 K/s}}}}
  bed:
    {{sensor: bed, heater: bed, period: 500 ms, algorithm: {{kind: on_off}},
     setpoint: {{initial: 0 °C, minimum: 10 °C, maximum: 110 °C}},
     protection: {{maximum: 130 °C, minimum: 5 °C}}}}
interfaces:
  - {{kind: gcode, baud: 19200, loops: {{T1: nozzle, T3: bed}}}}
"""


def on_host(program: Path) -> Board:
    return HostBoard(program, celsius(30), celsius(20, "bed"))


@pytest.fixture(params=["host", "binary"])
def board(request: pytest.FixtureRequest) -> Board:
    if request.param == "binary":
        return BinaryBoard(SPEC, nozzle=30.0, bed=20.0)
    return on_host(gcode_world(SPEC).sanitized().program())


def told(board: Board, *lines: str) -> list[str]:
    return [answer for line in lines for answer in board.told(line)]


def whole_degrees(answers: list[str]) -> list[str]:
    """The readings are as fine as the converter; what is not there reads 0.0."""
    return [re.sub(r"\b([TBC]\d?:\d\d)\.\d", r"\1.x", answer) for answer in answers]


def report(active: str, nozzle: str, bed: str) -> list[str]:
    return [f"ok T:{active} B:0.0 /0.0 T1:30.x /{nozzle} T3:20.x /{bed} @:0 @1:0 @3:0"]


def test_the_first_number_is_the_active_one_until_another_is_told(board: Board) -> None:
    assert whole_degrees(told(board, "M105")) == report("30.x /0.0", "0.0", "0.0")
    told(board, "M104 S15", "M104 T3 S12", "T3")
    assert whole_degrees(told(board, "M105")) == report("20.x /12.0", "15.0", "12.0")
    told(board, "M104 S0", "T1", "M104 S0")
    (wanted,) = report("30.x /0.0", "0.0", "0.0")
    assert whole_degrees(board.told("\n".join(12 * ["M105"]), 2.0)) == 12 * [wanted]
    if isinstance(board, HostBoard):
        assert board.said().state["line"] == "103 2 152 6 1"


def test_a_wait_is_for_its_own_tool(board: Board) -> None:
    """Each is there at once; the nozzle is not at its next target."""
    for line in ("M109 T3 S21", "M109 T1 S31"):
        assert told(board, line) == []
        board.wait(12.0)
        assert board.heard()[-1] == "ok"
    assert board.told("M109 T1 S100", 1.5)[0].startswith("T:30")
    assert board.told("M108", 0.2)[-1] == "ok"


def test_what_is_told_of_itself_is_of_the_active_tool(board: Board) -> None:
    told(board, "T3", "M155 S1", "M104 T1 S15")
    assert whole_degrees(board.told("", 1.3))[0].startswith("T:20.x /0.0 B")
    for _ in range(80):
        board.tell("M104 T1 S15\nM104 T1 S15", 0.02)
    reports = {each[:3] for each in whole_degrees(board.heard()) if each.startswith("T")}
    assert reports == {"T:2"}
    waiting = [each[:3] for each in board.told("M109 T1 S100", 2.5) if " W:" in each]
    assert waiting == ["T:3", "T:3"]
    assert whole_degrees(board.told("M108", 1.5))[-1].startswith("T:20.x /0.0 B")
    told(board, "M155 S0", "M104 T1 S15", "M104 S12", "M104 T1 S16")
    assert whole_degrees(board.told("M105"))[-1].startswith("ok T:20.x /12.0 B")


def test_duties_and_names_are_told(board: Board) -> None:
    assert board.lines()[1].startswith("echo:heatwright pair, spec ")
    (said, *_) = board.told("M115")
    assert said.startswith("FIRMWARE_NAME:heatwright spec ")
    assert "MACHINE_TYPE:pair EXTRUDER_COUNT:2" in said
    told(board, "M104 T3 S50", "M104 T1 D50")
    board.wait(1.0)
    assert board.told("M105")[0].endswith(" @:64 @1:64 @3:127")


BEYOND = "echo:M104 is outside its limits; nothing was changed"
UNABLE = "refused: this loop has no such control"
ANSWERS = {
    **{f"M104 T{tool} S50|T{tool}": (f"echo:M104 Invalid extruder {tool}", "ok",
                                     f'echo:Unknown command: "T{tool}"', "ok")
       for tool in (0, 2, 4, 255)},
    "T259": ('echo:Unknown command: "T259"', "ok"),
    "M104 T3 S111|M104 T1 S251": (BEYOND, "ok", BEYOND, "ok"),
    "M104 T1 S250|M104 T3 S110": ("ok", "ok"),
    "M301 T1 P5 I0.1 D10|M301 T1 P6|M503": (
        "echo:  M301 E1 P5.00000 I0.10000 D10.00000", "ok",
        *2 * ("echo:  M301 E1 P6.00000 I0.10000 D10.00000", "ok")),
    "M301 T3 P6|M303 T3 S50|M104 T3 D20": (
        f"echo:M301 {UNABLE}", "ok", f"echo:M303 {UNABLE}", "ok", f"echo:M104 {UNABLE}", "ok"),
    **{f"{line} E1": (f'echo:Unknown command: "{line}"', "ok")
       for line in ("M106", "M107", "G1", "G92", "M82", "M410", "M84", "M400")},
    "T3|T4|M104 S12": ("ok", 'echo:Unknown command: "T4"', "ok", "ok"),
    "M110 S1|M108|M114 S1|M140 S1|||": (
        "ok", "ok", "X:0.00 Y:0.00 Z:0.00 E:0.00", "ok",
        "echo:M140 refused: there is no heated bed or chamber", "ok"),
    "M 112|": ("ok", "Error:E19 STOPPED (M112): heaters are off until M999"),
}  # fmt: skip


@pytest.mark.parametrize(("lines", "answers"), ANSWERS.items(), ids=ANSWERS)
def test_each_tool_has_its_limits_and_controls_and_others_are_not_there(
    board: Board, lines: str, answers: tuple[str, ...]
) -> None:
    """Nor are a fan and a feed."""
    assert told(board, *lines.split("|")) == list(answers)


def swung(board: HostBoard) -> None:
    for count in range(1, 3):
        board.play(switched(count))
        board.wait(1.5)
    assert "bias: 64 d: 64 min: 30.00 max: 30.00" in board.heard()


def test_a_tuning_is_of_its_tool(board: Board) -> None:
    assert told(board, "T3", "M155 S1", "M303 T1 S100")[:3] == ["ok", "ok", "PID Autotune start"]
    if isinstance(board, HostBoard):
        swung(board)
        board.play(tuning_ends(2))
        board.wait(0.1)
        assert "Kp: 0.00000 Ki: 0.00000 Kd: 0.00000" in board.heard()
        assert board.said().state["tuning"] == "5"
    else:
        answers = told(board, "M155 S0\nM108")
        assert answers[-4:] == ["PID Autotune failed! Stopped", "ok", "ok", "ok"]
