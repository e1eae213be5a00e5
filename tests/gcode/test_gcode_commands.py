"""What each command does and answers."""

import re
from pathlib import Path

import gcode_world
import pytest
from gcode_world import celsius, fault, run, spoken, switched, talk, tuning_ends
from rig.firmware import changed, controller_of, sources_of
from rig.hosted import received, ticks

from heatwright.spec import digest

LIMITS = "J23.50000 K58.80000 Y100.00000"
COLD = "T:0.0 /0.0 B:0.0 /0.0 @:0"

LONGEST_PIECE, LONGEST_NUMBER = 80, 12
SPELT = re.compile(r'((?:say|plain)\()?PSTR\("((?:[^"\\]|\\.)*)"')

UNKNOWN = {
    "G28": "G28", "G1 E5": "G1", "M9999": "M9999", "M99999": "M", "M105.5": "M", "M": "M",
    "X5": "X5", "?": "?", "~": "~", "°": "?", "AT+GMM": "A", "M410": "M410",
    "A1": "A1", "a1": "A1", "Z9": "Z9", "z9": "Z9", "@1": "@", "[1": "[", "`": "`", "{": "{",
    "M1000": "M1000", "M10000": "M",
    "M900 K0.05": "M900", "M572 D0 S0.05": "M572",  # pressure advance: no motion control here
}  # fmt: skip
HOWEVER_WRITTEN = (
    "M105", "m105", " M105", "M\t105", "M 105", "M0105", "M105 ; how warm", "M105\r",
    "(how warm) M105", "(a;b) M105",
)  # fmt: skip
NO_COMMAND = ("", "   ", "; nothing", "(nothing)", "\r\n")


@pytest.mark.parametrize(
    ("line", "answers"),
    [
        *((line, [f"ok {COLD}"]) for line in HOWEVER_WRITTEN), *((line, []) for line in NO_COMMAND),
        *((line, [f'echo:Unknown command: "{shown}"', "ok"]) for line, shown in UNKNOWN.items()),
        *((f"{line} S60", [f"echo:{line} refused: there is no heated bed or chamber", "ok"])
          for line in ("M140", "M190", "M141", "M191")),
        ("T0", ["ok"]), ("M114", ["X:0.00 Y:0.00 Z:0.00 E:0.00", "ok"]),
        ("M301 P999.5 I1000 D1000.5",
         [f"echo:  M301 E0 P999.50000 I1000.00 D1000.50 {LIMITS}", "ok"]),
        ("M500", ["echo:Settings Stored", "ok"]),
        ("M501", ["echo:Stored settings retrieved", "ok"]),
        ("M502", ["echo:Hardcoded Default Settings Loaded", "ok"]),
        ("M301 P12345.67 I0.00005", [f"echo:  M301 E0 P12345.67 I0.00005 D0.00000 {LIMITS}", "ok"]),
        ("M301 J24 Y99.5", ["echo:  M301 E0 P0.00000 I0.00000 D0.00000 J24.00000 K58.80000 "
                            "Y99.50000", "ok"]),
    ],
)  # fmt: skip
def test_what_is_answered(world: Path, line: str, answers: list[str]) -> None:
    assert talk(world, line).answers == answers


@pytest.mark.parametrize(
    ("lines", "what", "numbers"),
    [
        *((line, "setpoint", [celsius]) for line, celsius in (
            ("M104 S200", 200), ("M104S200.5", 200.5), ("M104 T0 S+60", 60), ("m104 s0260", 260),
            ("M104 S 60", 60), ("M104 S0", 0), ("M109 S0", 0), ("M104 S1.0000000000000000001", 1),
            ("M104 E0 S99.95", 99.95), ("M104 S60.125", 60.125), ("M104S60T0", 60),
            ("M104 S0000000060", 60), ("M104 °S60", 60),
        )),
        *((f"M106 S128|{line}", "fan", [percent]) for line, percent in (
            ("M106", 100), ("M106 S", 100), ("M106 S51", 20), ("M106 P0 S1000", 100), ("M107", 0),
        )),
        *((f"M104 D30.5{more}", "manual", [30.5]) for more in ("", "|M104 D", "|M104 D T0")),
        ("M104 D30.5", "mode", [1]), ("M301 P0 I0 D0", "gains", [0, 0, 0]),
        ("M301 P1000000 I1000000 D1000000", "gains", [1e6, 1e6, 1e6]),
        ("M301 P9.41 I0.345 D31.4|M301 I0.00005|M301 E0 P12345.67", "gains",
         [12345.67, 0.00005, 31.4]),
        ("M301 P9 I1 D31|M301 I2", "gains", [9, 2, 31]),
        ("M301 J24.5|M301 K33.3|M301 Y60", "limits", [24.5, 33.3, 60]),
        ("M301 P1 J30 K40 Y50.125", "limits", [30, 40, 50.125]),
        ("M301 P999999.9999 I0.000005 D0", "gains", [1e6, 0.000005, 0]),
        ("M301 P9 I1 D31|M301 D5", "gains", [9, 1, 5]), ("M104\tS60", "setpoint", [60]),
        ("M500|M501|M501|M502|M502|M502", "stored", [1, 2, 3]),
    ],
)  # fmt: skip
def test_what_is_told_is_done(world: Path, lines: str, what: str, numbers: list[float]) -> None:
    said = talk(world, *lines.split("|"))
    answers = [answer for answer in said.answers if not answer.startswith("echo:")]
    assert answers == ["ok"] * len(lines.split("|"))
    found = [float(number) for number in said.state[what].split()]
    assert found == pytest.approx(numbers, rel=2**-24)


NO_NUMBER = "needs a number; nothing was changed"
NOT_WITHIN = "is outside its limits; nothing was changed"


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("M104 S260.001", NOT_WITHIN), ("M104 S-1", NOT_WITHIN), ("M104 S9999999", NOT_WITHIN),
        ("M109 S300", NOT_WITHIN), ("M104 S99999999", NO_NUMBER), ("M104", NO_NUMBER),
        ("M104 S", NO_NUMBER), ("M104 Sx", NO_NUMBER), ("M155 S1E1", NO_NUMBER),
        ("M104 S2 00", NO_NUMBER), ("M104 S2,5", NO_NUMBER), ("M104 S2.0.0", NO_NUMBER),
        ("M104 S--2", NO_NUMBER), ("M104 S.", NO_NUMBER), ("M104 T S200", NO_NUMBER),
        ("M104 S/1", NO_NUMBER), ("M104 S!5", NO_NUMBER), ("M104 S5°", NO_NUMBER),
        ("M104 S19999999", NO_NUMBER), ("M104 D99999999", NO_NUMBER), ("M104 D1E0", NO_NUMBER),
        ("M104 D°", NO_NUMBER), ("M104 S1:", NO_NUMBER), ("M104 T0.5 S200", NO_NUMBER),
        ("M104 T256 S200", NO_NUMBER), ("M104 S" + "9" * 60, NO_NUMBER), ("M104 D101", NOT_WITHIN),
        ("M104 D-1", NOT_WITHIN), ("M104 Dx", NO_NUMBER), ("M301 P-1", NOT_WITHIN),
        ("M301 P1000001", NOT_WITHIN), ("M301 P1 I1E-5", NO_NUMBER), ("M301 P1 I2 Dx", NO_NUMBER),
        ("M301 P5 J23.4", NOT_WITHIN), ("M301 P5 K58.9", NOT_WITHIN), ("M301 Y100.1", NOT_WITHIN),
        ("M301 J50 K40", NOT_WITHIN), ("M301 Y23.5", NOT_WITHIN), ("M301 P5 Y255", NOT_WITHIN),
        ("M301 P5 J", NO_NUMBER), ("M301 J25 Kx", NO_NUMBER), ("M301 K30 Y1..1", NO_NUMBER),
        ("M301 J25 P-1", NOT_WITHIN), ("M303 S261", NOT_WITHIN), ("M303", NO_NUMBER),
        ("M303 S200 C-1", NO_NUMBER),
        ("M303 S0", NOT_WITHIN), ("M106 S-1", NOT_WITHIN), ("M106 Sx", NO_NUMBER),
        ("M106 Px", NO_NUMBER), ("M155 S-1", NO_NUMBER),
    ],
)  # fmt: skip
def test_what_is_refused_changes_nothing(world: Path, line: str, reason: str) -> None:
    before = talk(world, "M104 S100", "M301 P1 I2 D3", "M106 S51").state
    said = talk(world, "M104 S100", "M301 P1 I2 D3", "M106 S51", line)
    assert said.answers[4:] == [f"echo:{line[:4]} {reason}", "ok"]
    assert said.state == before


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        *((line, f"{line[:4]} Invalid extruder 1") for line in (
            "M104 T1 S100", "M109 T1 S100", "M109 T1 R100", "M104 E1 S100", "M301 T1 P7",
            "M303 T1 S100", "M104 T1 D9",
        )),
        ("T1", 'Unknown command: "T1"'), ("M106 P1", "M106 Invalid fan 1"),
        ("M107 P7", "M107 Invalid fan 7"),
    ],
)  # fmt: skip
def test_what_is_for_another_tool_or_fan_changes_nothing(
    world: Path, line: str, answer: str
) -> None:
    said = talk(world, line, "M105")
    assert said.answers == [f"echo:{answer}", "ok", f"ok {COLD}"]
    assert said.state == talk(world, "M105").state


@pytest.mark.parametrize(
    ("lines", "count", "answers"),
    [
        (b"M155 S2\n", 650, ["ok", COLD, COLD, COLD]),
        (b"M155 S2\nM155 S1.5\n", 650, ["ok", f"echo:M155 {NO_NUMBER}", "ok", COLD, COLD, COLD]),
        (b"M155 S1\n", 10_050, ["ok", *100 * [COLD]]),
        (b"M140 S1\n", 250, ["echo:M140 refused: there is no heated bed or chamber", "ok"]),
        (b"M155 S2\nM155 S0\n", 650, ["ok", "ok"]),
        *((line, 300 * every_s + more, ["ok", COLD, COLD, *last])
          for line, every_s in ((b"M155\n", 1), (b"M155 S60\n", 60), (b"M155 S61\n", 60),
                               (b"M155 S200\n", 60))
          for more, last in ((-50, []), (50, [COLD]))),
    ],
)  # fmt: skip
def test_reports_come_each_second_at_most_and_each_minute_at_least(
    world: Path, lines: bytes, count: int, answers: list[str]
) -> None:
    assert run(world, received(lines), ticks(count)).answers == answers


M109 = celsius(20) + received(b"M109 S200\n")
TUNE = received(b"M303 E0 S200\n") + ticks(250)


def test_m109_and_m303_tell_how_it_goes(world: Path) -> None:
    """A report a second of what is waited for, every two of a tuning; also a sign of life."""
    said = run(world, M109, ticks(1000)).answers
    assert said.count("T:20.0 /200.0 B:0.0 /0.0 @:0 W:?") == 9
    for count, busy in ((202, 0), (203, 1), (402, 1), (403, 2)):
        said = run(world, M109, ticks(count)).answers
        assert said.count("echo:busy: processing") == busy
    there = run(world, celsius(200), M109[5:], ticks(1010)).answers
    left = [answer.rpartition(":")[2] for answer in there if " W:" in answer]
    assert left == list("987654321")
    tuning = run(world, TUNE)
    assert tuning.answers[0] == "PID Autotune start"
    assert tuning.answers.count("T:0.0 /200.0 B:0.0 /0.0 @:0") == 2
    assert "ok" not in tuning.answers
    assert tuning.state["tuning"] == "5"
    assert run(world, M109, switched(2), ticks(50)).answers == []


@pytest.mark.parametrize(
    ("script", "ended"),
    [
        ([M109, ticks(500), celsius(200), ticks(1000)], False),
        ([M109, ticks(500), celsius(200), ticks(1001)], True),
        ([M109, celsius(200), ticks(600), celsius(190), ticks(20), celsius(200), ticks(900)],
         False),
        ([celsius(250), received(b"M109 S200\n"), ticks(50)], True),
        ([celsius(250), received(b"M109 R200\n"), ticks(50)], False),
        ([M109, received(b"M104 S100\n"), ticks(300)], False),
        ([M109, ticks(100), gcode_world.setpoint_becomes(200), ticks(100)], False),
        *(([M109, ticks(90), received(urgent), ticks(10)], True)
          for urgent in (b"M108\n", b"N7 M108*99\n", b"m108 ;\n")),
    ],
    ids=["not_yet", "10_s_after_the_heat_is_there", "interrupted", "cooling", "cooling_with_R",
         "nothing_else_is_done", "still_the_same_setpoint",
         "M108", "numbered_M108", "M108_with_comment"],
)  # fmt: skip
def test_when_a_wait_ends(world: Path, script: list[bytes], ended: bool) -> None:
    said = run(world, *script)
    assert said.answers[-1:] == ["ok"] or not ended
    assert ended or "ok" not in said.answers
    assert said.state["setpoint"] == "200"


def test_a_fault_that_trips_again_at_once_is_told_again_and_a_code_of_no_rule(world: Path) -> None:
    """Acknowledged by the host, or by a key. Damaged memory may hold any code."""
    for again in ((received(b"M999\n"), ticks(1)), (b"k", ticks(20))):
        told = run(world, fault(1), ticks(20), *again, fault(1), ticks(20)).answers
        assert sum(answer.startswith("Error:E01") for answer in told) == 2
    for code in (200, 255):
        told = run(world, fault(code), ticks(20)).answers
        assert sum(answer.startswith("Error:E?? NO SUCH CODE (at ") for answer in told) == 1


@pytest.mark.parametrize("line", ["M112", "M 112"])
def test_a_stop_is_told(world: Path, line: str) -> None:
    """Also by a line that the receiver does not recognise at once."""
    said = talk(world, line)
    told = {"ok", "Error:E19 STOPPED (M112): heaters are off until M999"}
    assert set(said.answers) == told
    assert (said.state["fault"], said.state["tripped"]) == ("19", "0")


def test_m303_tells_of_its_swings(world: Path) -> None:
    """From the second time that the relay switches on: the lowest and highest since the first."""
    script = [celsius(190), received(b"M303 E0 S200 C5\n"), ticks(20)]
    swings = (200, 205, 195), (203, 12500000, 193, 200), (193.5, 194)
    for count, swing in enumerate(swings, 1):
        parts = (part for degrees in swing for part in (celsius(degrees), ticks(5)))
        script += [switched(count), ticks(5), *parts]
    shown = [answer for answer in run(world, *script).answers if answer.startswith("bias: ")]
    limits = ("190.00 max: 205.00", "193.00 max: 12500000.00")
    assert shown == [f"bias: 64 d: 64 min: {each}" for each in limits]


LATCHED = "M104 S200", "M109 S200", "M303 S200", "M104 D10", "M104 S0", "M999", "M104 S100"
TUNING = received(b"M303 S200\n") + ticks(50)
FAILURES = {3: "timeout", 4: "Stopped", 5: "Temperature too high",
            6: "The gains found are of no use"}  # fmt: skip
ENDS = {
    "a fault while it waits": (
        [celsius(20), received(b"M109 S200\n"), ticks(50), fault(10), ticks(20)],
        ["Error:E10 NO HEATING (at 20.0 C): heaters are off until M999", "ok"], "200"),
    "a fault that is locked out waits for a person": (
        [fault(6), b"l\x03", ticks(20), *spoken("M999"), b"l\x02", *spoken("M999")],
        ["echo:M999 refused: locked out after repeated faults; at the machine, "
         "take all power away, the USB's too, for a minute, and wait 600 s", "ok", "ok"], "0"),
    "a latched fault refuses heat until acknowledged": (
        [fault(6), ticks(20), *spoken(*LATCHED)],
        [part for line in LATCHED[:4] for part in (
            f"echo:{line[:4]} refused: acknowledge the fault with M999", "ok")] + 3 * ["ok"],
        "100"),
    **{f"{setpoint} °C while it waits": (
        [M109, ticks(50), gcode_world.setpoint_becomes(setpoint), ticks(10)], ["ok"],
        str(setpoint)) for setpoint in (60, 210)},
    **{f"{degrees} °C": (
        [celsius(degrees), *spoken("M105")], [f"ok T:{told} /0.0 B:0.0 /0.0 @:0"], "0")
       for degrees, told in ((-0.04, "0.0"), (-0.06, "-0.1"), (-12.34, "-12.3"), (9.96, "10.0"),
                             (1e9, "20000000.0"), (float("nan"), "20000000.0"))},
    "a tuning, and a line that waits": (
        [TUNING, received(b"M104 T7 S1\n"), tuning_ends(4), ticks(10)],
        ["PID Autotune failed! Stopped", "ok", "echo:M104 Invalid extruder 7", "ok"], "200"),
    "a tuning": (
        [*spoken("M301 P1 I2 D3"), TUNING, tuning_ends(2), ticks(10)],
        ["Kp: 1.00000 Ki: 2.00000 Kd: 3.00000", "Integral: {minimum: 0.0 %, maximum: 0.0 %}",
         "echo:  M301 E0 J0.00000 K0.00000",
         "PID Autotune finished! The gains are in use and stored.", "ok"], "200"),
    **{f"a tuning: {why}": ([TUNING, tuning_ends(result), ticks(10)],
                            [f"PID Autotune failed! {why}", "ok"], "200")
       for result, why in FAILURES.items()},
    "a tuning that M108 stops": ([TUNING, received(b"M108\n"), ticks(20)],
                                 ["PID Autotune failed! Stopped", "ok", "ok"], "0"),
}  # fmt: skip


@pytest.mark.parametrize(("script", "last", "setpoint"), ENDS.values(), ids=ENDS)
def test_how_it_ends(world: Path, script: list[bytes], last: list[str], setpoint: str) -> None:
    said = run(world, *script)
    assert said.answers[-len(last) :] == last
    assert said.state["setpoint"] == setpoint


def test_it_greets_and_says_what_it_is(world: Path) -> None:
    said = talk(world, "M115")
    spec = digest(controller_of("extruder"))
    assert said.lines[1] == f"echo:heatwright extruder, spec {spec}"
    assert said.answers[0].startswith(f"FIRMWARE_NAME:heatwright spec {spec} ")
    assert "MACHINE_TYPE:extruder EXTRUDER_COUNT:1" in said.answers[0]
    # No reports by itself, so that a host polls.
    told = ("EEPROM:1", "AUTOREPORT_TEMP:0", "EMERGENCY_PARSER:1", "CHAMBER_TEMPERATURE:0")
    assert said.answers[1:] == [*(f"Cap:{each}" for each in told), "ok"]


@pytest.mark.parametrize("name", ["extruder", "feeder"])
def test_no_piece_of_a_report_is_longer_than_the_room_it_waits_for(name: str) -> None:
    """It would be cut; most have a number behind them."""
    longest = changed(name, (f"name: {name}\n", f"name: {'n' * 24}\n"))
    text = sources_of(longest)["gcode_report.c"]
    assert f"LONGEST_PIECE = {LONGEST_PIECE}" in text
    spelt = SPELT.findall(text)
    pieces = [(alone, len(said.encode().decode("unicode_escape"))) for alone, said in spelt]
    assert len(pieces) > 40
    assert all(size <= LONGEST_PIECE - (0 if alone else LONGEST_NUMBER) for alone, size in pieces)
