"""Bed and chamber: their commands and their place in the reports, beside tools or without any."""

import pytest
from gcode_world import BinaryBoard, Board, HostBoard, gcode_world
from rig.firmware import changed
from test_gcode_tools import CURVE, SPEC, on_host, swung, whole_degrees

CALLED = {
    "bed and chamber": "B: nozzle, C: bed",
    "tools and chamber": "T0: bed, T1: spare, C: nozzle",
    "tool and bed": "T1: nozzle, B: bed",
}
"""The nozzle is at 30 °C and has gains, the bed is at 20 °C and on or off."""
SPARE = [
    ("outputs:\n", f"  spare: {{kind: thermistor, pin: A2, {CURVE}, range: 0 °C .. 300 °C}}\n"),
    ("loops:\n", "  spare: {kind: pwm, pin: D10, frequency: 100 Hz, power: 40 W}\n"),
    ("interfaces:\n", """  spare:
    {sensor: spare, heater: spare, period: 500 ms, algorithm: {kind: pid, kp: 4, ki: 5, kd: 6},
     setpoint: {initial: 0 °C, minimum: 10 °C, maximum: 250 °C},
     protection: {maximum: 280 °C, minimum: 5 °C}}
"""),
]  # fmt: skip
"""A second tool, at 40 °C and with gains."""
LIMITED = [
    ("kd: 10}", "kd: 10, limits_adjustable: true}"),
    ("rise_rate: 20 K/s", "rise_rate: 20 K/s, runaway: {above: 15 K, below: 15 K}"),
]
"""The nozzle's limits may be set; the second tool has none."""
UNCHECKED = ("interfaces:\n", "safety: {self_checks: false}\ninterfaces:\n")
"""An Uno has no room for them then."""


def spec_of(called: str) -> str:
    spare = [(head, text + head) for head, text in SPARE]
    more = [*spare, *LIMITED, UNCHECKED] if "spare" in CALLED[called] else []
    return changed(SPEC, ("T1: nozzle, T3: bed", CALLED[called]), *more)


@pytest.fixture(params=CALLED)
def called(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(params=["host", "binary"])
def board(request: pytest.FixtureRequest, called: str) -> Board:
    if request.param == "binary":
        spare = {"spare": 40.4} if "spare" in CALLED[called] else {}
        return BinaryBoard(spec_of(called), nozzle=30.0, bed=20.0, **spare)
    return on_host(gcode_world(spec_of(called)).sanitized().program())


UNABLE = "refused: this loop has no such control"
NAMELESS = "refused: name the heater by E, T or H"
NO_NUMBER = "needs a number; nothing was changed"
BEYOND = "is outside its limits; nothing was changed"
GAINS = "P1.00000 I2.00000 D3.00000"
SPARE_GAINS = "echo:  M301 E1 P4.00000 I5.00000 D6.00000"
LIMITS = "J5.00000 K60.50000 Y80.00000"
ANSWERS = {
    "bed and chamber": [
        ("M105", "ok T:0.0 /0.0 B:30.x /0.0 C:20.x /0.0 @:0 B@:0 C@:0"),
        ("M141 S50", ""), ("M140 S15.5", ""),
        ("M105", "ok T:0.0 /0.0 B:30.x /15.5 C:20.x /50.0 @:0 B@:0 C@:127"),
        ("M141 S111", f"echo:M141 {BEYOND}"), ("M140 S111", ""),
        ("M140 S251", f"echo:M140 {BEYOND}"), ("M141 S0", ""), ("M140", f"echo:M140 {NO_NUMBER}"),
        ("M190", f"echo:M190 {NO_NUMBER}"),
        ("M191 R", f"echo:M191 {NO_NUMBER}"), ("M190 S20", ""), ("M191 S0", ""),
        ("M141 D9", f"echo:M141 {UNABLE}"), ("M140 D50", ""),
        ("M105", "ok T:0.0 /0.0 B:30.x /20.0 C:20.x /0.0 @:0 B@:64 C@:0"),
        ("M304 P1 I2 D3", f"echo:  M304 {GAINS}"), ("M503", f"echo:  M304 {GAINS}"),
        ("M309 P1", f"echo:M309 {UNABLE}"), ("M301 P1", "echo:M301 Invalid extruder 0"),
        ("M140 S20", ""),
        ("M303 S99 E-2", f"echo:M303 {UNABLE}"), ("M303 E-3 S99", f"echo:M303 {NO_NUMBER}"),
        *((f"{line} S20", f"echo:{line} Invalid extruder 0") for line in ("M104", "M109", "M303")),
        *((f"M303 S99 H{n}", f"echo:M303 Invalid extruder {n}") for n in (1, 11, 12)),
        ("M303 H-1 S99", f"echo:M303 {NO_NUMBER}"), ("M303 H S99", f"echo:M303 {NO_NUMBER}"),
        ("M104 T10 S20", "echo:M104 Invalid extruder 10"), ("T0", 'echo:Unknown command: "T0"'),
    ],
    "tools and chamber": [
        ("M105", "ok T:20.x /0.0 B:0.0 /0.0 C:30.x /0.0 T0:20.x /0.0 T1:40.x /0.0 "
                 "@:0 C@:0 @0:0 @1:0"),
        ("M104 S50", ""), ("M141 S15", ""), ("T0", ""), ("M141 D50", ""),
        ("M104 T1 S12", ""), ("M104 T1 D25", ""),
        ("M105", "ok T:20.x /50.0 B:0.0 /0.0 C:30.x /15.0 T0:20.x /50.0 T1:40.x /12.0 "
                 "@:127 C@:64 @0:127 @1:32"),
        ("M140 S60", "echo:M140 refused: there is no heated bed"),
        ("M190 S300", "echo:M190 refused: there is no heated bed"),
        ("M304 P1", 'echo:Unknown command: "M304"'), ("M301 P1", f"echo:M301 {UNABLE}"),
        ("M309 P1 I2 D3 J5 K60.5 Y80", f"{SPARE_GAINS}|echo:  M309 {GAINS} {LIMITS}"),
        ("M309 Y5", f"echo:M309 {BEYOND}"), ("M309 J61", f"echo:M309 {BEYOND}"),
        ("M309 Y101", f"echo:M309 {BEYOND}"), ("M309 K101", f"echo:M309 {BEYOND}"),
        ("M301 T1 P1 J5", f"echo:M301 {UNABLE}"), ("M301 T1 Y50", f"echo:M301 {UNABLE}"),
        ("M309", f"{SPARE_GAINS}|echo:  M309 {GAINS} {LIMITS}"),
        ("M301 T1 P4", f"{SPARE_GAINS}|echo:  M309 {GAINS} {LIMITS}"),
        ("M303 E-1 S99", f"echo:M303 {NO_NUMBER}"), ("M303 P1 S99", f"echo:M303 {NAMELESS}"),
        *((f"M303 S99 {spare}", f"echo:M303 {UNABLE}") for spare in ("T1", "E1", "H2", "H2 P1")),
        ("M303 S99 H0", "echo:M303 Invalid extruder 0"), ("T11", 'echo:Unknown command: "T11"'),
        ("M104 T11 S1", "echo:M104 Invalid extruder 11"), ("M104 S0", ""),
    ],
    "tool and bed": [
        ("M105", "ok T:30.x /0.0 B:20.x /0.0 @:0 B@:0"),
        ("M140 S50", ""), ("M104 S15", ""), ("M105", "ok T:30.x /15.0 B:20.x /50.0 @:0 B@:127"),
        ("M141 S60", "echo:M141 refused: there is no heated chamber"),
        ("M191 S300", "echo:M191 refused: there is no heated chamber"),
        ("M309 P1", 'echo:Unknown command: "M309"'), ("M304 P1", f"echo:M304 {UNABLE}"),
        ("M301 P1 I2 D3", f"echo:  M301 E1 {GAINS}"), ("M503", f"echo:  M301 E1 {GAINS}"),
        ("M140 D9", f"echo:M140 {UNABLE}"),
        *((f"M303 {bed} S99", f"echo:M303 {UNABLE}") for bed in ("E-1", "T-1", "H0")),
    ],
}  # fmt: skip
OF_ALL = [
    ("M500", "echo:Settings Stored"), ("M501", "echo:Stored settings retrieved"),
    ("M502", "echo:Hardcoded Default Settings Loaded"), ("M155 S0", ""), ("M999", ""),
]  # fmt: skip
TUNED = {
    "bed and chamber": ("E-1", "T-1", "H0"),
    "tools and chamber": ("E-2", "T-2"),
    "tool and bed": ("E1", "T1 P0", "H2", ""),
}
"""What can be tuned, the first by the test's own relay."""


def test_each_is_commanded_and_told_by_its_own_name(board: Board, called: str) -> None:
    for line, answer in [*ANSWERS[called], *OF_ALL]:
        ends = [] if answer.startswith("ok") else ["ok"]
        said = board.told(line, 0.9)  # with a step of the loop
        assert whole_degrees(said) == [*filter(None, answer.split("|")), *ends], line
    assert board.told(f"M303 {TUNED[called][0]} S99") == ["PID Autotune start"]
    if isinstance(board, HostBoard):
        swung(board)
        assert board.said().state["tuning"] == "5"
    assert board.told("M108", 0.2)[-3:] == ["PID Autotune failed! Stopped", "ok", "ok"]
    for heater in TUNED[called][1:]:
        assert board.told(f"M303 {heater} S99") == ["PID Autotune start"], heater
        assert board.told("M108", 0.2)[-3:] == ["PID Autotune failed! Stopped", "ok", "ok"]


WAITS = {
    "bed and chamber": {"M190": (31, "T:0.0 /0.0 B:30.x /"),
                        "M191": (21, "T:0.0 /0.0 B:30.x /11.0 C:20.x /")},
    "tools and chamber": {"M191": (31, "T:20.x /0.0 B:0.0 /0.0 C:30.x /"),
                          "M109 T1": (41, "T:40.x /"), "M109": (21, "T:20.x /")},
    "tool and bed": {"M190": (21, "T:30.x /0.0 B:20.x /"), "M109": (31, "T:30.x /")},
}  # fmt: skip


def test_a_wait_is_for_bed_or_chamber_and_tells_of_the_active_tool(
    board: Board, called: str
) -> None:
    """It is there after 10 s; with S, what is warmer is there too."""
    for line, (near, report) in WAITS[called].items():
        waited = whole_degrees(board.told(f"{line} S{near}", 1.5))[0]
        assert waited.startswith(f"{report}{near}.0 ")
        assert waited.endswith(" W:9")
        board.wait(10.0)
        assert board.heard()[-1] == "ok"
        assert board.told(f"{line} S12", 0.5) == ["ok"]
        waited = whole_degrees(board.told(f"{line} R11", 1.5))[0]
        assert waited.startswith(f"{report}11.0 ")
        assert waited.endswith(" W:?")
        assert board.told("M108", 0.5)[-2:] == ["ok", "ok"]


def test_it_introduces_itself(board: Board, called: str) -> None:
    start, greeting = board.lines()[:2]
    assert start == "start"
    assert greeting.startswith("echo:heatwright pair, spec ")
    said, *capabilities, ok = board.told("M115")
    assert said.startswith("FIRMWARE_NAME:heatwright spec ")
    assert said.endswith(f" EXTRUDER_COUNT:{CALLED[called].count('T')}")
    there = int("C:" in CALLED[called])
    assert capabilities[-1] == f"Cap:CHAMBER_TEMPERATURE:{there}"
    assert ok == "ok"
