"""Extruder and feeder, tuned on the machine itself: the gains are robust on any, and good on ours.
The extruder's converter reads in steps of 0.53 K at 200 °C, and without noise four codes give no
more than one. So the heater is thrown about by each step, and the block with it, faster than the
sensor can follow; what is held of the block is its mean over five seconds, about one lag of the
sensor."""

import numpy as np
import pytest
from machines import FEED_MM_PER_S, HOLD_S, PHASES, PLANTS, TUNED_S, assert_margins, run_of, tuned

from heatwright.sim.judges.metrics import metrics

LOOP = "nozzle"
TARGETS = {"extruder": 200.0, "feeder": 210.0}
DONE = 2


@pytest.mark.parametrize(("capacity", "resistance"), PLANTS)
@pytest.mark.parametrize("name", TARGETS)
def test_on_any_machine_the_loop_is_robust(name, capacity, resistance):
    found = tuned(name, TARGETS[name], capacity, resistance)
    assert found.log["autotune.result"].max() == DONE
    assert set(found.log["fault.code"]) == {0}
    assert found.log["temperature_c"].max() < TARGETS[name] + 20
    assert_margins(found.controller, found.device.gains(LOOP))


@pytest.mark.parametrize("name", TARGETS)
def test_the_host_tunes_it(name):
    _, device, trace = run_of(name)
    log = trace.steps[LOOP]
    done = log[np.searchsorted(log["time_s"], TUNED_S) - 1]
    assert done["autotune.result"] == DONE
    assert done["setpoint_c"] == 0  # off, until it is told to heat
    for gain in ("kp", "ki", "kd"):
        assert device.read(f"settings.{LOOP}_{gain}") == done[f"autotune.{gain}"]
        assert log[f"algorithm.{gain}"][-1] == done[f"autotune.{gain}"]
    assert device.host.texts("PID Autotune finished!")


OVERSHOOT_K, DIP_K, WITHIN_K, BACK_S = 1.0, 2.0, 0.5, 20.0  # what the extruder is held to
ON_S, FED_S, STOPPED_S = 1500.0, 1700.0, 1760.0
MEAN_S = 5.0


def test_the_extruder_keeps_to_what_it_is_held_to():
    run = run_of("extruder")
    assert run.between(ON_S - 1, ON_S)["temperature_c"].max() < 30
    assert 0 < run.between(ON_S, FED_S)["temperature_c"].max() - 200 <= OVERSHOOT_K
    fed, stopped = metrics(run.trace, run.controller).disturbances[:2]
    assert (fed.at_s, fed.what, stopped.at_s) == (FED_S, "extrude 5 mm/s", STOPPED_S)
    assert fed.dip_k <= DIP_K
    assert fed.recovered_after_s is not None
    assert fed.recovered_after_s <= BACK_S
    assert stopped.rise_k <= OVERSHOOT_K
    assert set(run.log["fault.code"]) == {0}


def test_so_does_its_block():
    trace = run_of("extruder").trace
    count = round(MEAN_S / trace.times_s[1])
    errors_k = trace.temperatures_c["block"] - 200.0
    means_k = np.convolve(errors_k, np.full(count, 1 / count), "valid")
    times_s = trace.times_s[count - 1 :]
    assert means_k[(times_s > ON_S) & (times_s < FED_S)].max() <= OVERSHOOT_K
    assert -errors_k[trace.times_s >= FED_S].min() <= DIP_K
    fed = (times_s >= FED_S + BACK_S) & (times_s < STOPPED_S)
    assert np.abs(means_k[fed]).max() <= WITHIN_K


LOOKED_AT_S = 120.0
AIM_K = 0.3
"""What we aim at, at the element itself; what is read of it may be off by half a step of the
converter, 0.13 K, more. The published machine held +0.9 and −0.8 K."""


@pytest.mark.parametrize(("target_c", "feeds", "start_s"), PHASES)
def test_the_feeder_is_steady(target_c, feeds, start_s):
    fed, end_s = run_of("feeder"), start_s + HOLD_S
    looked_at = fed.between(end_s - LOOKED_AT_S, end_s)
    assert set(looked_at["setpoint_c"]) == {target_c}
    half_step_k = fed.controller.sensors[LOOP].step_at_k(target_c, "atmega328p") / 2
    errors_k = looked_at["temperature_c"] - target_c
    assert abs(errors_k).max() <= AIM_K + half_step_k
    steady = (fed.trace.times_s > end_s - LOOKED_AT_S) & (fed.trace.times_s < end_s)
    assert abs(fed.trace.sensed_c[LOOP][steady] - target_c).max() <= AIM_K
    moved = fed.trace.fed_mm_per_s[steady].mean()
    assert moved == pytest.approx(FEED_MM_PER_S if feeds else 0.0, abs=0.05)
