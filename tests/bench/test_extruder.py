"""The extruder with the gains that tuning found: from cold, and under filament.

Its converter reads in steps of 0.53 K at 200 °C, and without noise four codes give no more than
one. So the heater is thrown about by each step, and the block with it, faster than the sensor can
follow; what is held of the block is its mean over five seconds, about one lag of the sensor.
"""

import numpy as np
import pytest
from machines import example, run, tuned

from heatwright.sim.metrics import metrics

FED_S, STOPPED_S, END_S = 200.0, 260.0, 400.0
OVERSHOOT_K, DIP_K, WITHIN_K, BACK_S = 1.0, 2.0, 0.5, 20.0
"""What the extruder is held to."""
MEAN_S = 5.0


@pytest.fixture(scope="module")
def trace():
    return run(
        example("extruder"),
        tuned("extruder", 200.0).line,
        {"at": "1 s", "send": "M104 S200"},
        {"at": f"{FED_S} s", "extrude": "5 mm/s"},
        {"at": f"{STOPPED_S} s", "extrude": "0 mm/s"},
        {"for": f"{END_S} s"},
    )


@pytest.fixture(scope="module")
def figures(trace):
    return metrics(trace, example("extruder"))


def block_mean(trace):
    """Return times and means over five seconds of the block's error, K."""
    step_s = trace.times_s[1]
    count = round(MEAN_S / step_s)
    errors_k = trace.temperatures_c["block"] - 200.0
    return trace.times_s[count - 1 :], np.convolve(errors_k, np.full(count, 1 / count), "valid")


def test_from_cold(figures):
    assert figures.setpoint_c == 200
    assert 0 < figures.overshoot_k <= OVERSHOOT_K


def test_the_block_itself_from_cold(trace):
    times_s, means_k = block_mean(trace)
    assert means_k[times_s < FED_S].max() <= OVERSHOOT_K


def test_filament(figures):
    fed, _ = figures.disturbances
    assert (fed.at_s, fed.what) == (FED_S, "extrude 5 mm/s")
    assert fed.dip_k <= DIP_K
    assert fed.recovered_after_s is not None
    assert fed.recovered_after_s <= BACK_S


def test_the_block_itself_under_filament(trace):
    times_s, means_k = block_mean(trace)
    fed = (times_s >= FED_S) & (times_s < STOPPED_S)
    assert -(trace.temperatures_c["block"][trace.times_s >= FED_S] - 200).min() <= DIP_K
    assert np.abs(means_k[fed & (times_s >= FED_S + BACK_S)]).max() <= WITHIN_K


def test_when_the_filament_stops(figures):
    _, stopped = figures.disturbances
    assert stopped.at_s == STOPPED_S
    assert stopped.rise_k <= OVERSHOOT_K


def test_no_protection_trips(trace):
    assert set(trace.steps["nozzle"]["fault.code"]) == {0}


def test_the_filament_takes_heat(trace):
    """5 mm/s · 0.0056 J/(K·mm) · 180 K ≈ 5 W more."""
    on = trace.on_fraction["heater"] * 40
    before = on[(trace.times_s > 150) & (trace.times_s < FED_S)].mean()
    during = on[(trace.times_s > 220) & (trace.times_s < STOPPED_S)].mean()
    assert during - before == pytest.approx(5.04, rel=0.05)
