"""Figures of what happens to a machine, on signals whose figures are known."""

from dataclasses import replace

import pytest
from test_metrics import trace_of

from heatwright.sim.disturbances import disturbances
from heatwright.sim.metrics import metrics
from heatwright.sim.trace import TraceEvent

FEED, STOP = TraceEvent(4.5, "extrude 5 mm/s", True), TraceEvent(9.5, "extrude 0 mm/s", True)


def disturbed(readings_c, *events, setpoints_c=None):
    count = len(readings_c)
    trace = trace_of(readings_c, setpoints_c or [50] * count, [0] * count)
    return replace(trace, events=events)


def test_each_lasts_until_the_next():
    trace = disturbed(
        [40, 50, 51, 50, 48, 49, 49.5, 49.5, 50, 50.75, 50.25, 50], FEED, TraceEvent(9, "S"), STOP
    )
    fed, stopped = disturbances(trace, trace.steps["air"])
    assert (fed.at_s, fed.what, fed.dip_k, fed.rise_k) == (4.5, "extrude 5 mm/s", 2, 0)
    assert fed.recovered_after_s == 2.5  # at 7 s, to stay
    assert (stopped.dip_k, stopped.rise_k, stopped.recovered_after_s) == (0, 0.75, 1.5)


def test_one_that_is_not_borne():
    trace = disturbed([50, 50, 50, 50, 48, 50, 48], FEED)
    (fed,) = disturbances(trace, trace.steps["air"])
    assert fed.recovered_after_s is None


def test_one_that_is_hardly_felt():
    trace = disturbed([50, 50, 50, 50, 49.5, 50.5, 50], FEED)
    (fed,) = disturbances(trace, trace.steps["air"])
    assert fed.recovered_after_s == 0
    (strictly,) = disturbances(trace, trace.steps["air"], within_k=0.25)
    assert strictly.recovered_after_s == 2.5


def test_one_after_the_last_step_is_left_out():
    trace = disturbed([50, 50, 50], FEED)
    assert disturbances(trace, trace.steps["air"]) == ()


def test_the_response_ends_where_something_happens(chamber):
    trace = disturbed([40, 45, 50, 50.5, 44, 55, 50], FEED)
    found = metrics(trace, chamber)
    assert (found.maximum_c, found.overshoot_k) == (50.5, 0.5)
    assert found.disturbances[0].dip_k == 6


def test_only_what_happens_after_the_last_setpoint_counts(chamber):
    setpoints_c = [50] * 6 + [30] * 4
    trace = disturbed([50, 50, 50, 50, 45, 50, 50, 40, 30, 30], FEED, STOP, setpoints_c=setpoints_c)
    (stopped,) = metrics(trace, chamber).disturbances
    assert stopped.what == STOP.text
    assert stopped.recovered_after_s == pytest.approx(0.0)
