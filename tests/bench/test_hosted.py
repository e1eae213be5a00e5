"""How the model hears a host; what it takes and refuses is the binary's (test_replay)."""

import pytest
from machines import at, course, example, modelled

from heatwright.sim.bench import ReferenceDevice
from heatwright.sim.reference.line import parsed

AUTOMATIC, TUNING = 0, 2


@pytest.mark.parametrize(
    ("text", "command", "words"),
    [
        ("M104 S200", "M104", {"S": 200.0}),
        ("N12 M104 T0 S200.5*91", "M104", {"T": 0.0, "S": 200.5}),
        ("g1 e5 f300 ; feed", "G1", {"E": 5.0, "F": 300.0}),
        ("M104 D", "M104", {"D": None}),
        ("M303S180C3", "M303", {"S": 180.0, "C": 3.0}),
        ("G92 E-.5", "G92", {"E": -0.5}),
    ],
)
def test_lines(text, command, words):
    assert parsed(text) == (command, words)


@pytest.mark.parametrize("text", ["", "; nothing", "T0", "M", "S200"])
def test_a_line_without_a_command_is_an_error(text):
    with pytest.raises(ValueError, match="no command"):
        parsed(text)


def test_without_a_host_nobody_listens(chamber):
    with pytest.raises(ValueError, match="no gcode interface"):
        ReferenceDevice(chamber).send("M104 S30")


def model(name, felt_c):
    found = ReferenceDevice(example(name))
    found.sense("nozzle", felt_c)
    found.advance(1.05)
    return found


@pytest.fixture
def device():
    return model("extruder", 25.0)


def last(device):
    return device.steps("nozzle")[-1]


def told(device, *lines):
    for line in lines:
        device.send(line)
    device.advance(round(last(device)["time_s"]) + 1.05)
    return last(device)


def test_what_lets_a_host_wait():
    """The model keeps nobody waiting; tests/gcode shows how long the binary does."""
    lines = at({0.5: "M109 S210.5", 2: "M303 S200 C3", 4: "M108"})
    found = course(modelled("extruder", *lines, {"for": "6 s"}).log, "setpoint_c", "mode")
    assert found == [(0, AUTOMATIC), (210.5, AUTOMATIC), (200, TUNING), (0, AUTOMATIC)]


def test_by_hand_as_it_is(device):
    now = told(device, "M104 S26")["duty_percent"]
    assert 0 < now < 100
    assert told(device, "M104 D")["manual_percent"] == now


def test_the_fan(device):
    for lines, share in (("M106 P0 S127.5", 0.5), ("M106|M106 P5 S0", 1.0), ("M107", 0.0)):
        told(device, *lines.split("|"))
        device.on_fraction("part_fan")
        told(device)
        assert device.on_fraction("part_fan") == pytest.approx(share, abs=1 / 256)


def fed_mm(device, lines, seconds):
    """How far the feed goes after these lines."""
    device.travel_mm("feed")
    for line in filter(None, lines.split("|")):
        device.send(line)
    device.advance(round(last(device)["time_s"]) + seconds)
    return device.travel_mm("feed")


@pytest.mark.parametrize(
    ("lines", "seconds", "length_mm", "within_mm"),
    [
        ("G1 E10 F120", 3, 6, 0.6),
        ("G1 E10 F120", 9, 10, 1e-5),
        ("G1 E10 F1200|G92 E0|G1 E3|M83|G1 E3|G1 E-1", 5, 15, 1e-5),
        ("G1 E100 F600|M410", 3, 0, 0.2),
        ("G1 E200 F600|M112", 3, 2, 0.2),  # until the next step
    ],
)
def test_the_feed(lines, seconds, length_mm, within_mm):
    device = model("feeder", 210.0)
    told(device, "M104 S210")
    assert fed_mm(device, lines, seconds) == pytest.approx(length_mm, abs=within_mm)


def test_the_feed_waits_for_the_loop_and_does_not_outlive_a_fault():
    device = model("feeder", 208.5)
    told(device, "M104 S210")
    assert fed_mm(device, "G1 E10 F600", 3) == 0
    device.sense("nozzle", 209.5)
    assert fed_mm(device, "", 3) == pytest.approx(10, abs=3)
    told(device, "G1 E200 F600", "M112")
    assert fed_mm(device, "M999|M104 S210", 3) == 0
