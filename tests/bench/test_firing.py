"""Figures of merit of programs on logs whose figures are known."""

import csv

import numpy as np
import pytest
from machines import at, example, modelled

from heatwright.sim.firing import firing_of
from heatwright.sim.metrics import metrics
from heatwright.sim.reference.program_state import IDLE, PAUSED, RUNNING

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
    found = metrics(trace, kiln)
    assert found.tracking_k is not None
    assert (found.rise_time_s, found.settling_s) == (None, None)
    trace.write_csv(tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(encoding="utf-8") as file:
        header = next(csv.reader(file))
    assert f"{LOOP}.program.segment" in header
    assert not any("loaded" in name for name in header)
