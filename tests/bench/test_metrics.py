"""Figures of merit, of a response and of a firing, on signals whose figures are known."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from machines import at, example, modelled
from numpy.lib.recfunctions import append_fields

from heatwright.sim.judges import metrics as judged
from heatwright.sim.judges.disturbances import disturbances
from heatwright.sim.judges.firing import firing_of
from heatwright.sim.reference.programs.state import IDLE, PAUSED, RUNNING
from heatwright.sim.trace import Trace, TraceEvent
from heatwright.spec import PwmOutput, TimeProportionalOutput


def trace_of(readings_c, setpoints_c, duties, fractions=None):
    count = len(readings_c)
    singles = [(name, "f4") for name in ("setpoint_c", "temperature_c", "duty_percent")]
    log = np.zeros(count, [
        ("time_s", "f8"), *singles, ("has_reading", "u1"), ("reading_status", "u1"),
    ])  # fmt: skip
    log["time_s"] = np.arange(1, count + 1)
    log["setpoint_c"], log["temperature_c"] = setpoints_c, readings_c
    log["duty_percent"], log["has_reading"] = duties, 1
    on = np.concatenate(([0.0], np.asarray(duties if fractions is None else fractions) / 100))
    return Trace(np.arange(count + 1.0), {}, {}, {"heater": on, "fan": on}, {"air": log})


def test_a_response_with_known_figures(chamber):
    readings = [20, 20, 23, 30, 45, 47, 52, 51, 50, 49.9375, 50, 50.0625]
    duties = [0, 100, 100, 100, 0, 100] + [0] * 6
    found = judged.metrics(trace_of(readings, [20] + [50] * 11, duties), chamber)
    assert (found.setpoint_c, found.maximum_c, found.overshoot_k) == (50, 52, 2)
    assert found.rise_time_s == 3  # from 23 °C to 47 °C
    assert found.settling_s == 7  # at 50 °C, within 0.6 K from there on
    assert (found.steady_minimum_c, found.steady_maximum_c) == (49.9375, 50.0625)
    assert found.steady_error_k == 0.0625
    assert found.iae_ks == 30 + 27 + 20 + 5 + 3 + 2 + 1 + 0 + 0.0625 + 0 + 0.0625
    assert (found.switchings, found.audible, found.energy_j) == (2, False, 240 * 4)


def test_only_the_last_response_counts(chamber):
    readings = [60, 60, 20, 30, 30, 30]
    found = judged.metrics(trace_of(readings, [60, 60, 30, 30, 30, 30], [0] * 6), chamber)
    assert (found.setpoint_c, found.maximum_c, found.overshoot_k) == (30, 30, 0)


@pytest.mark.parametrize(
    ("readings_c", "beyond_k", "rise_s", "settled_s"),
    [
        ([20.0, 25.0, 30.0, 40.0], 0, None, None),  # it never arrives
        ([50.0, 50.0625, 50.0], 0.0625, None, 0),  # from the start
        ([40.0, 50.0, 50.0, 50.0, 50.3], 0.3, 0, None),  # it leaves the band again
        ([20.0, 52.0, 49.0], 2, 0, None),
        ([60.0, 49.0, 50.5], 1, 0, None),  # overshoot is in the direction of the step
    ],
)
def test_overshoot_rise_and_settling(readings_c, beyond_k, rise_s, settled_s):
    readings_c = np.array(readings_c)
    times_s = np.arange(float(len(readings_c)))
    assert judged.overshoot(readings_c, 50.0) == pytest.approx(beyond_k)
    assert judged.rise_time(times_s, readings_c, 50.0) == rise_s
    assert judged.settling(times_s, readings_c, 50.0, 0.0625) == settled_s


@pytest.mark.parametrize(
    ("output", "expected", "audible"),
    [
        ({"kind": "pwm", "frequency": "490 Hz"}, 2 * 490 + 1, True),
        ({"kind": "pwm", "frequency": "25 kHz"}, 2 * 25000 + 1, False),
        ({"kind": "time_proportional", "window": "2 s"}, 2 * 0.5 + 1, False),
    ],
)
def test_switchings_of_a_partial_duty(vary, output, expected, audible):
    kind = PwmOutput if output["kind"] == "pwm" else TimeProportionalOutput
    model = kind.model_validate({"pin": "D3", "power": "240 W", **output})
    trace = trace_of([20] * 6, [50] * 6, [0, 100, 100, 50, 50, 0])
    found = judged.metrics(trace, vary(output=model))
    assert found.switchings == expected
    assert found.audible is audible


def counted(*duties):
    """A log that also says how many steps of its window an output is on for."""
    log = trace_of([20] * len(duties), [50] * len(duties), duties).steps["air"]
    return append_fields(log, "output.on_steps", np.array(duties, "u2"), usemask=False)


def test_spread_over_a_window_it_switches_once_for_each_pulse(vary):
    made = {"kind": "time_proportional", "pin": "D3", "power": "240 W", "window": "2 s"}
    spread = {"resolution": "20 ms", "distribution": "spread"}
    controller = vary(output=TimeProportionalOutput.model_validate(made | spread))
    log = counted(0, 100, 30, 80, 0)
    # Full power begins once; 30 pulses and 20 pauses in windows of 2 s, a step of 1 s each.
    assert judged.switchings(log, controller, "air") == 1 + 30 / 2 + 20 / 2
    assert not judged.audible(log, controller, "air")
    assert judged.audible(counted(50), controller, "air")  # 25 Hz


def test_energy_is_what_the_pin_gave_not_what_was_asked(chamber):
    trace = trace_of([20] * 4, [50] * 4, [100] * 4, fractions=[0, 100, 50, 0])
    assert judged.metrics(trace, chamber).energy_j == 240 * 1.5


def test_a_run_without_a_reading_has_no_figures(chamber):
    trace = trace_of([20] * 3, [50] * 3, [0] * 3)
    trace.steps["air"]["has_reading"] = 0
    trace.steps["air"]["reading_status"] = 1
    with pytest.raises(ValueError, match=r"no reading of sensor air .* sensor_no_answer"):
        judged.metrics(trace, chamber)


FEED, STOP = TraceEvent(4.5, "extrude 5 mm/s", True), TraceEvent(9.5, "extrude 0 mm/s", True)


def disturbed(readings_c, *events, setpoints_c=None):
    count = len(readings_c)
    trace = trace_of(readings_c, setpoints_c or [50] * count, [0] * count)
    return replace(trace, events=events)


def borne(trace, **within):
    """How each was borne: dip, rise, and after how long it was over."""
    found = disturbances(trace, trace.steps["air"], **within)
    return [(each.what, each.dip_k, each.rise_k, each.recovered_after_s) for each in found]


def test_each_lasts_until_the_next():
    readings_c = [40, 50, 51, 50, 48, 49, 49.5, 49.5, 50, 50.75, 50.25, 50]
    trace = disturbed(readings_c, FEED, TraceEvent(9, "S"), STOP)
    assert borne(trace) == [(FEED.text, 2, 0, 2.5), (STOP.text, 0, 0.75, 1.5)]  # at 7 s, to stay
    assert disturbances(trace, trace.steps["air"])[0].at_s == 4.5


@pytest.mark.parametrize(
    ("readings_c", "within", "expected"),
    [
        ([50, 50, 50, 50, 48, 50, 48], {}, [(FEED.text, 2, 0, None)]),  # it is not borne
        ([50, 50, 50, 50, 49.5, 50.5, 50], {}, [(FEED.text, 0.5, 0.5, 0)]),  # hardly felt
        ([50, 50, 50, 50, 49.5, 50.5, 50], {"within_k": 0.25}, [(FEED.text, 0.5, 0.5, 2.5)]),
        ([50, 50, 50], {}, []),  # after the last step
    ],
)
def test_when_one_is_over(readings_c, within, expected):
    assert borne(disturbed(readings_c, FEED), **within) == expected


def test_the_response_ends_where_something_happens(chamber):
    found = judged.metrics(disturbed([40, 45, 50, 50.5, 44, 55, 50], FEED), chamber)
    assert (found.maximum_c, found.overshoot_k, found.disturbances[0].dip_k) == (50.5, 0.5, 6)


def test_only_what_happens_after_the_last_setpoint_counts(chamber):
    setpoints_c = [50] * 6 + [30] * 4
    trace = disturbed([50, 50, 50, 50, 45, 50, 50, 40, 30, 30], FEED, STOP, setpoints_c=setpoints_c)
    (stopped,) = judged.metrics(trace, chamber).disturbances
    assert (stopped.what, stopped.recovered_after_s) == (STOP.text, pytest.approx(0.0))


LOOP = "chamber"
OVER, FAST, HOLD = 1, 3, 4
FIELDS = [
    *((name, "f4") for name in ("temperature_c", "setpoint_c", "duty_percent")),
    ("reading_status", "u1"), ("program.state", "u1"), ("program.segment", "u1"),
    ("program.segment_clock", "u4"), ("program.kind", "u1"),
    ("program.from_c", "f4"), ("program.to_c", "f4"),
]  # fmt: skip


def part(number, kind, errors_k, *, way=(0.0, 100.0), duty=50.0, status=0, state=RUNNING):
    """One segment, and how far the readings were from its setpoint, second by second."""
    rows = np.zeros(len(errors_k), FIELDS)
    rows["setpoint_c"] = way[1]
    rows["temperature_c"] = way[1] + np.asarray(errors_k, float)
    rows["duty_percent"], rows["reading_status"] = duty, status
    rows["program.state"], rows["program.segment"], rows["program.kind"] = state, number, kind
    rows["program.segment_clock"] = np.arange(1, len(errors_k) + 1)
    rows["program.from_c"], rows["program.to_c"] = way
    return rows


def fired(*parts):
    return firing_of(np.concatenate(parts), example("kiln").loops[LOOP])


def test_it_is_not_where_the_heater_is_at_an_end():
    ramp = part(1, OVER, [0.25] * 200)
    for rows, duty in ((slice(70, 90), 0.0), (slice(100, 120), 100.0)):
        ramp["temperature_c"][rows] += 7
        ramp["duty_percent"][rows] = duty
    assert fired(ramp).tracking_k == 0.25


def test_after_a_pause_it_is_judged_from_the_second_minute_on_again():
    first, pause = part(1, OVER, [0.5] * 70), part(1, OVER, [9.0] * 30, state=PAUSED)
    second = part(1, OVER, [5.0] * 60 + [-0.75] * 9)
    second["program.segment_clock"] += 70
    assert fired(first, pause, second).tracking_k == 0.75
    assert fired(first, second).tracking_k == 5.0


@pytest.mark.parametrize(
    ("parts", "tracking_k"),
    [
        ([part(1, OVER, [5.0] * 60 + [-0.5] * 30 + [0.25] * 30)], 0.5),  # from the 2nd minute on
        ([part(1, HOLD, [9.0] * 100)], None),
        ([part(1, FAST, [9.0] * 100)], None),
        ([part(1, OVER, [9.0] * 60)], None),
        ([part(1, OVER, [9.0] * 100, way=(50.0, 50.0))], None),
        ([part(1, OVER, [0.0] * 60), part(1, OVER, [9.0] * 60)], None),  # begun anew
    ],
)
def test_only_a_ramp_is_tracked(parts, tracking_k):
    assert fired(*parts).tracking_k == tracking_k


def test_a_hold_is_passed_in_the_direction_of_the_way():
    up, down = part(1, OVER, [0.0] * 9), part(3, OVER, [0.0] * 9, way=(100.0, 20.0))
    low = {"way": (20.0, 20.0)}
    assert fired(up, part(2, HOLD, [-3.0, 0.75, 0.5])).overshoot_k == 0.75
    assert fired(up, part(2, HOLD, [-3.0, -0.5])).overshoot_k == 0
    assert fired(down, part(4, HOLD, [3.0, -0.5, 0.1], **low)).overshoot_k == 0.5


def test_the_steady_part_is_the_last_third_of_the_last_hold():
    found = fired(part(1, HOLD, [9.0] * 9), part(2, OVER, [0.0] * 9), part(3, HOLD, range(9)))
    assert [float(each) for each in found.steady["temperature_c"]] == [106.0, 107.0, 108.0]


def test_without_a_program_there_is_no_firing(chamber):
    assert fired(part(1, OVER, [1.0], state=IDLE)) is None
    assert fired(part(1, OVER, [1.0], status=1)) is None
    log = np.zeros(3, [("temperature_c", "f4")])
    assert firing_of(log, chamber.loops["air"]) is None


def test_a_run_of_the_kiln_has_its_figures_and_its_columns(tmp_path):
    kiln, _, trace = modelled("kiln", *at({2: "start 1"}, "program"), {"for": "3 min"})
    found = judged.metrics(trace, kiln)
    assert found.tracking_k is not None
    assert (found.rise_time_s, found.settling_s) == (None, None)
    trace.write_csv(tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(encoding="utf-8") as file:
        header = next(csv.reader(file))
    assert f"{LOOP}.program.segment" in header
    assert not any("loaded" in name for name in header)
