"""The bench: a controller's model on its machine, what is done when, and what is watched."""

import csv
from types import SimpleNamespace

import numpy as np
import pytest
from machines import at, course, events, example, modelled, noisy
from rig.firmware import changed, controller_of, whole

from heatwright.sim.bench import PROGRESS_REPORTS, ReferenceDevice, bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.judges.interlock import Interlock
from heatwright.sim.native.pins import PIN_EVENT, pin_number
from heatwright.sim.reference.interfaces.gcode import parsed
from heatwright.sim.scenario import Action, actions, end_s
from heatwright.sim.trace import TraceEvent
from heatwright.spec import Pid, ProgramOrder, PwmOutput, TimeProportionalOutput, Write

HEATER = {"pin": "D3", "power": "240 W"}
PWM = PwmOutput.model_validate({"kind": "pwm", "frequency": "490 Hz", **HEATER})
WINDOWS = TimeProportionalOutput.model_validate(
    {"kind": "time_proportional", "window": "1 s", **HEATER}
)


@pytest.fixture(scope="module")
def run():
    return modelled("chamber").trace


def test_one_step_per_period_up_to_the_end(run):
    log = run.steps["air"]
    assert log["time_s"].tolist() == [float(n) for n in range(1, 1801)]
    assert log["steps"].tolist() == list(range(1, 1801))
    assert run.events == tuple(TraceEvent(pytest.approx(t), "up") for t in (10.0, 10.2, 10.4))
    assert log["setpoint_c"][8:11].tolist() == [20.0, 30.0, 50.0]  # a press at 10 s comes first


def test_readings_are_what_the_sensor_felt_when_its_conversion_began(run):
    log = run.steps["air"]
    felt_c = np.interp(log["time_s"] - 0.8, run.times_s, run.sensed_c["air"])  # row before 0.78 s
    assert log["reading_raw"].tolist() == np.floor(felt_c * 16 + 0.5).tolist()


def test_the_heater_follows_the_step(run):
    log = run.steps["air"]
    after = np.searchsorted(run.times_s, log["time_s"] + 0.05)
    on = run.on_fraction["heater"]
    assert np.array_equal(on[after[:-1]] * 100, log["duty_percent"][:-1])
    assert (run.on_fraction["fan"][1:] == 1).all()


def test_seed_changes_the_noise(chamber):
    one, same, other = (
        modelled(noisy(chamber, 0.1), {"for": "20 s"}, seed=seed).trace.sensed_c["air"].tolist()
        for seed in (1, 1, 2)
    )
    assert one == same != other


def test_progress_ends_at_the_end(chamber):
    told = []
    lines, tell = events({"for": "60 s"}), lambda now_s, end_s: told.append(now_s / end_s)
    bench(chamber, ReferenceDevice(chamber), lines, progress=tell)
    assert told == sorted(told)
    assert 0.99 < told[-1] <= 1
    assert len(told) <= 2 * PROGRESS_REPORTS


@pytest.mark.parametrize(("output", "resolution"), [(PWM, 1 / 256), (WINDOWS, 10e-3)])
def test_the_heat_is_what_was_asked_for(vary, output, resolution):
    controller = vary(algorithm=Pid(kind="pid", kp=1), output=output)
    keys = {"at": "1.5 s", "press": "up", "times": 3}
    trace = modelled(controller, keys, {"for": "30 s"}).trace
    log = trace.steps["air"][:-1]  # what the last step asks for is still to come
    assert 25 < log["duty_percent"].max() < 100
    until = np.searchsorted(trace.times_s, 30.0 + 1e-9)
    given_s = (trace.on_fraction["heater"] * np.diff(trace.times_s, prepend=0.0))[:until].sum()
    asked_s = log["duty_percent"].astype(float).sum() / 100
    assert given_s == pytest.approx(asked_s, abs=len(log) * resolution / 2)


def test_csv_has_units_and_the_state_of_the_last_step(chamber, tmp_path):
    trace = bench(chamber, ReferenceDevice(chamber), events({"for": "3 s"}), step_s=0.1)
    path = tmp_path / "run.csv"
    trace.write_csv(path)
    with path.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert header[:5] == ["time [s]", "element [°C]", "air [°C]", "walls [°C]", "air sensed [°C]"]
    units = {"temperature_c": "°C", "algorithm.rate_k_per_s": "K/s", "duty_percent": "%"}
    assert {f"air.{name} [{unit}]" for name, unit in units.items()} <= {*header}
    steps = [row[header.index("air.steps")] for row in rows]
    assert steps == [""] * 10 + ["1"] * 10 + ["2"] * 10 + ["3"] * 2


def test_keys_of_a_menu_move_the_setpoint_on_its_page_alone():
    """As the binary has it: not where the state is shown, nor at another value."""
    keys = ("up", "left", "up", "up", "right", "up", "left", "select", "up")
    lines = [{"at": f"{2 * turn + 1.5} s", "press": key} for turn, key in enumerate(keys)]
    lines += [{"for": "22 s"}]
    controller = controller_of("kiln_uno")
    devices = ReferenceDevice(controller), AvrDevice(controller, whole("kiln_uno"))
    model, binary = (bench(controller, each, events(*lines)).steps["chamber"] for each in devices)
    assert len(set(model["setpoint_c"][:20].tolist())) == 3
    assert model["setpoint_c"].tolist() == binary["setpoint_c"].tolist()


def up(at_s, **more):
    return {"at": f"{at_s} s", "press": "up", **more}


@pytest.mark.parametrize(
    ("lines", "expected", "texts"),
    [
        # Each press is down and up.
        ([up(10, times=2), {"for": "1 min"}],
         [Action(10.0, "up"), Action(10.1), Action(10.2, "up"), Action(10.3)],
         ["up", None, "up", None]),
        # An event waits for the hand to be free.
        ([up(1, times=2), {"at": "1.2 s", "press": "select"}],
         [Action(1.0, "up"), Action(1.1), Action(1.2, "up"), Action(1.3), Action(1.4, "select"),
          Action(1.5)],
         ["up", None, "up", None, "select", None]),
        # Events are done in the order of their times.
        ([up(5), {"at": "1 s", "press": "down"}],
         [Action(1.0, "down"), Action(1.1), Action(5.0, "up"), Action(5.1)],
         ["down", None, "up", None]),
        ([{"at": "9 s", "extrude": "5 mm/s"}, {"at": "1 s", "send": "M104 S200"}, up(1)],
         [Action(1.0, line="M104 S200"), Action(1.0, "up"), Action(1.1),
          Action(9.0, extrude_mm_per_s=5.0)],
         ["M104 S200", "up", None, "extrude 5 mm/s"]),
        # A master writes one value after the other.
        ([{"at": "2 s", "write": {"air.setpoint": "60 °C", "air.enabled": True}}],
         [Action(2.0, write=Write("air.setpoint", 60.0)),
          Action(2.0, write=Write("air.enabled", True))],
         ["air.setpoint = 60", "air.enabled = on"]),
        *(([{"at": "3 s", "program": said}],
           [Action(3.0, program=ProgramOrder(word, int(*number)))], [said])
          for said in ("start 2", "pause", "resume", "skip", "jump 3", "stop")
          for word, *number in (said.split(),)),
    ],
)  # fmt: skip
def test_what_is_done_when(lines, expected, texts):
    found = actions(events(*lines))
    times_s = [each.time_s for each in expected]
    assert [each.time_s for each in found] == pytest.approx(times_s)
    assert [each._replace(time_s=0.0) for each in found] == [
        each._replace(time_s=0.0) for each in expected
    ]
    assert [each.text for each in found] == texts


def test_the_end_is_the_for():
    assert end_s(events(up(1), {"for": "30 min"})) == 1800
    with pytest.raises(ValueError, match="needs its end"):
        end_s(events(up(1)))


def test_a_fan_and_a_feed_happen_to_the_machine():
    quiet = [Action(0.0, line="M104 S200"), Action(0.0, "up")]
    quiet += [Action(0.0, write=Write("air.setpoint", 60.0))]
    quiet += [Action(0.0, program=ProgramOrder("pause"))]
    felt = [Action(0.0, line=line) for line in ("M106 P0 S255", "m107", "G1 E5 F300")]
    felt += [Action(0.0, extrude_mm_per_s=0.0)]
    assert [each.disturbs for each in quiet + felt] == [False] * 4 + [True] * 4


# ---- heater and cooler at their pins: one cycle together is seen ----

CLOCK_HZ = 1_000_000
H, C = "PD5", "PD6"
CUT = [(10, H, 1), (15, H, 0), (20, C, 1), (25, H, 1), (26, C, 0)]


def watch(active="high"):
    heater, cooler = SimpleNamespace(pin=H, active="high"), SimpleNamespace(pin=C, active=active)
    return Interlock(heater, cooler, CLOCK_HZ)


def feed(watched, *changes):
    rows = [(cycle, pin_number(pin), level) for cycle, pin, level in changes]
    watched.feed(np.array(rows, PIN_EVENT), None)


@pytest.mark.parametrize(
    ("active", "batches", "together"),
    [
        ("high", [[(10, H, 1), (20, H, 0), (20, C, 1), (30, C, 0)]], None),
        ("high", [[(10, H, 1), (20, C, 1), (21, H, 0), (30, C, 0)]], 20),  # a single cycle
        ("high", [[(10, H, 1), (20, C, 1)]], 20),  # until the end
        ("low", [[(5, C, 1), (10, H, 1)]], None),
        ("low", [[(5, C, 1), (10, H, 1), (20, C, 0)]], 20),
        ("high", [[(10, H, 1), (20, "PB0", 1), (30, H, 0)]], None),  # another pin
        *(("high", [CUT[:at], CUT[at:]], 25) for at in range(5)),  # wherever the reading is cut
    ],
)
def test_only_together_is_seen(active, batches, together):
    found = watch(active)
    for batch in batches:
        feed(found, *batch)
    assert found.overlap_s == (together and pytest.approx(together / CLOCK_HZ))


def test_a_loss_of_power_is_off():
    found = watch()
    feed(found, (10, H, 1))
    found.power_on(1.0)
    feed(found, (5, C, 1))
    assert found.overlap_s is None
    feed(found, (50, H, 1))
    assert found.overlap_s == pytest.approx(1 + 50 / CLOCK_HZ)


# ---- how the model hears a host; what it takes and refuses is the binary's (test_replay) ----

AUTOMATIC, BY_HAND, TUNING = 0, 1, 2


@pytest.mark.parametrize(
    ("text", "command", "words"),
    [
        ("M104 S200", "M104", {"S": 200}), ("N12 M104 T0 S2.5*91", "M104", {"T": 0, "S": 2.5}),
        ("g1 e5 f300 ; feed", "G1", {"E": 5, "F": 300}), ("M104 D", "M104", {"D": None}),
        ("M303S180C3", "M303", {"S": 180, "C": 3}), ("G92 E-.5", "G92", {"E": -0.5}),
    ],
)  # fmt: skip
def test_lines(text, command, words):
    assert parsed(text) == (command, words)


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


ORDERS = {"T0": ("M104", "M109", "M303"), "B": ("M140", "M190", "M303 E-1"),
          "C": ("M141", "M191", "M303 E-2")}  # fmt: skip


@pytest.mark.parametrize(
    ("called", "heater"),
    [("T0", "H1"), ("T0", "T0 P1"), ("T0", "E0"), ("B", "H0"), ("B", "T-1"), ("C", "T-2")],
)
def test_a_tuning_is_of_the_heater_that_hosts_name_in_their_ways(called, heater):
    """What names none, or another, tunes none."""
    text = changed("extruder", ("{T0: nozzle}", f"{{{called}: nozzle}}"))
    others = {"P1", "H7", "H", "T-3", "E4", "H0", "H1", "E0"} - {heater}
    others -= {"E0", "H1"} if called == "T0" else {"H0"} if called == "B" else set()
    lines = [*(f"M303 S150 {each}" for each in sorted(others)), f"M303 S199 {heater}"]
    run = modelled(
        controller_of(text), *at({1 + place: line for place, line in enumerate(lines)}),
        {"for": "12 s"},
    )  # fmt: skip
    assert course(run.log, "setpoint_c", "mode") == [(0, AUTOMATIC), (199, TUNING)]


@pytest.mark.parametrize("called", ORDERS)
def test_what_a_host_calls_bed_and_chamber_has_commands_of_its_own(called):
    text = changed("extruder", ("{T0: nozzle}", f"{{{called}: nozzle}}"))
    heat, wait, tune = ORDERS[called]
    others = [f"{word} S30" for name in ORDERS if name != called for word in ORDERS[name]]
    lines = *others, f"{heat} S210", *others, f"{wait} R180", f"{wait} D9", f"{heat} D40", *others
    lines = at({0.5 + place: line for place, line in enumerate((*lines, f"{tune} S200 C3"))})
    run = modelled(controller_of(text), *lines, {"for": "35 s"})
    found = course(run.log, "setpoint_c", "mode")
    assert found == [(0, AUTOMATIC), (210, AUTOMATIC), (180, AUTOMATIC), (180, BY_HAND),
                     (200, TUNING)]  # fmt: skip


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
    device.travel_mm("feed")
    for line in filter(None, lines.split("|")):
        device.send(line)
    device.advance(round(last(device)["time_s"]) + seconds)
    return device.travel_mm("feed")


@pytest.mark.parametrize(
    ("lines", "seconds", "length_mm", "within_mm"),
    [
        ("G1 E10 F120", 3, 6, 0.6), ("G1 E10 F120", 9, 10, 1e-5),
        ("G1 E10 F1200|G92 E0|G1 E3|M83|G1 E3|G1 E-1", 5, 15, 1e-5),
        ("G1 E100 F600|M410", 3, 0, 0.2), ("G1 E200 F600|M112", 3, 0, 0),
    ],
)  # fmt: skip
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
