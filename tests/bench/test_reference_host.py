"""The reference device hears a host as the firmware does: what may be, is done; else nothing."""

import pytest
from machines import example, run

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.reference.line import parsed
from heatwright.spec import Event

OFF, AUTOMATIC, MANUAL, TUNING = 0, 0, 1, 2


@pytest.fixture
def device():
    found = ReferenceDevice(example("extruder"))
    found.sense("nozzle", 25.0)
    found.advance(1.05)
    return found


def last(device):
    return device.steps("nozzle")[-1]


def told(device, *lines):
    for line in lines:
        device.send(line)
    device.advance(round(last(device)["time_s"]) + 1.05)
    return last(device)


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


def test_the_setpoint_and_off(device):
    assert told(device, "M104 S200")["setpoint_c"] == 200
    assert told(device, "M109 S210.5")["setpoint_c"] == 210.5
    assert told(device, "M104 S0")["duty_percent"] == 0


@pytest.mark.parametrize("line", ["M104 S261", "M104 S-5", "M104", "M104 D101", "M303 S0"])
def test_what_is_refused_changes_nothing(device, line):
    before = told(device, "M104 S200")
    after = told(device, line)
    assert (after["setpoint_c"], after["mode"]) == (before["setpoint_c"], before["mode"])


def test_by_hand_and_back(device):
    told(device, "M104 S200")
    by_hand = told(device, "M104 D30")
    assert (by_hand["mode"], by_hand["duty_percent"], by_hand["setpoint_c"]) == (MANUAL, 30, 200)
    assert told(device, "M104 S200")["mode"] == AUTOMATIC


def test_by_hand_as_it_is(device):
    now = told(device, "M104 S26")["duty_percent"]
    assert 0 < now < 100
    assert told(device, "M104 D")["manual_percent"] == now


def test_gains(device):
    told(device, "M104 S200", "M301 P5 I0.25")
    assert [float(gain) for gain in device.gains] == [5.0, 0.25, pytest.approx(31.4)]
    told(device, "M301 P-1", "M301 I2000000")
    assert [float(gain) for gain in device.gains][:2] == [5.0, 0.25]


def test_a_stop_refuses_heat_until_it_is_acknowledged(device):
    told(device, "M104 S200")
    assert told(device, "M112")["fault.code"] == 19
    assert told(device, "M104 S210")["setpoint_c"] == 200
    assert told(device, "M303 S210")["mode"] == AUTOMATIC
    assert told(device, "M104 D10")["mode"] == AUTOMATIC
    after = told(device, "M999")
    assert (after["fault.code"], after["setpoint_c"], after["duty_percent"]) == (0, 0, 0)


def test_a_tuning_stops_when_told(device):
    assert told(device, "M303 S200 C3")["mode"] == TUNING
    after = told(device, "M108")
    assert (after["autotune.result"], after["mode"], after["setpoint_c"]) == (4, AUTOMATIC, 0)


def test_m108_leaves_all_else(device):
    told(device, "M104 S200", "M108")
    assert last(device)["setpoint_c"] == 200


def test_the_fan(device):
    told(device, "M106 P0 S127.5")
    device.on_fraction("part_fan")
    told(device)
    assert device.on_fraction("part_fan") == pytest.approx(0.5, abs=1 / 256)
    told(device, "M106", "M106 P5 S0")
    device.on_fraction("part_fan")
    told(device)
    assert device.on_fraction("part_fan") == 1
    told(device, "M107")
    device.on_fraction("part_fan")
    told(device)
    assert device.on_fraction("part_fan") == 0


def test_the_fan_cools_the_machine():
    ends = {"for": "300 s"}
    heat = {"at": "1 s", "send": "M104 D20"}
    still = run(example("extruder"), "M105", heat, ends)
    blown = run(example("extruder"), "M106 S255", heat, ends)
    assert blown.temperatures_c["block"][-1] < still.temperatures_c["block"][-1] - 10


@pytest.fixture
def feeder():
    found = ReferenceDevice(example("feeder"))
    found.sense("nozzle", 210.0)
    found.send("M104 S210")
    found.advance(1.0)
    return found


def fed_mm(device, seconds):
    device.travel_mm("feed")
    device.advance(round(last(device)["time_s"]) + seconds)
    return device.travel_mm("feed")


def test_the_feed_goes_its_way_at_its_speed(feeder):
    feeder.send("G1 E10 F120")
    assert fed_mm(feeder, 3) == pytest.approx(6, abs=0.6)
    assert fed_mm(feeder, 3) == pytest.approx(4, abs=0.6)
    assert fed_mm(feeder, 3) == 0


def test_places_and_ways(feeder):
    for line in ("G1 E10 F1200", "G92 E0", "G1 E3", "M83", "G1 E3", "G1 E-1"):
        feeder.send(line)
    assert fed_mm(feeder, 5) == pytest.approx(15)


def test_the_feed_waits_until_the_loop_is_ready(feeder):
    feeder.send("G1 E10 F600")
    feeder.sense("nozzle", 208.5)
    feeder.advance(1.5)
    assert fed_mm(feeder, 3) == 0
    feeder.sense("nozzle", 209.5)
    assert fed_mm(feeder, 3) == pytest.approx(10, abs=3)


def test_the_feed_is_forgotten_at_a_fault_and_when_told(feeder):
    feeder.send("G1 E100 F600")
    feeder.send("M410")
    assert fed_mm(feeder, 2) == 0
    feeder.send("G1 E200 F600")
    feeder.send("M112")
    feeder.advance(4.0)
    feeder.send("M999")
    feeder.send("M104 S210")
    assert fed_mm(feeder, 3) == 0


def test_the_feed_draws_heat():
    trace = bench(
        example("feeder"),
        ReferenceDevice(example("feeder")),
        [
            Event.model_validate(line)
            for line in (
                {"at": "1 s", "send": "M104 S210"},
                {"at": "200 s", "send": "G1 E100 F300"},
                {"for": "230 s"},
            )
        ],
    )
    moving = trace.fed_mm_per_s > 0
    assert trace.fed_mm_per_s.sum() * trace.times_s[1] == pytest.approx(100, rel=1e-9)
    assert trace.times_s[moving].min() >= 200
