"""Extruder and feeder, tuned on the machine itself: the gains are robust on any, and good on ours.

The extruder's converter reads in steps of 0.53 K at 200 °C, and without noise four codes give no
more than one. So the heater is thrown about by each step, and the block with it, faster than the
sensor can follow; what is held of the block is its mean over five seconds, about one lag of the
sensor.
"""

from typing import NamedTuple

import numpy as np
import pytest
from bench_runs import EXTRUDER, TUNED_S, run_of
from machines import PLANTS, assert_margins, at, commanded, example, fired, scaled, tuned

from heatwright.sim.metrics import metrics
from heatwright.sim.replay import replay
from heatwright.sim.tuning.process import process_of

LOOP = "nozzle"
TARGETS = {"extruder": 200.0, "feeder": 210.0}
DONE = 2


@pytest.mark.parametrize(("capacity", "resistance"), PLANTS)
@pytest.mark.parametrize("name", TARGETS)
class TestOnAnyMachine:
    def test_it_comes_to_an_end_without_a_fault(self, name, capacity, resistance):
        found = tuned(name, TARGETS[name], capacity, resistance)
        assert found.log["autotune.result"].max() == DONE
        assert set(found.log["fault.code"]) == {0}
        assert found.log["temperature_c"].max() < TARGETS[name] + 20

    def test_the_loop_is_robust(self, name, capacity, resistance):
        gains = tuned(name, TARGETS[name], capacity, resistance).gains
        assert_margins(scaled(example(name), capacity, resistance), gains)

    def test_it_finds_the_machine(self, name, capacity, resistance):
        controller = scaled(example(name), capacity, resistance)
        target_c, loop = TARGETS[name], controller.loops[LOOP]
        found = measured(tuned(name, target_c, capacity, resistance).log, loop.period_s)
        plant, ambient_c = controller.simulation.plant, controller.simulation.ambient_c
        (link,), (sense,) = plant.links, plant.sense.values()
        power_w = controller.outputs["heater"].power_w
        holds_percent = 100 * (target_c - ambient_c) / link.resistance_k_per_w / power_w
        # Each time is found to two steps, and it holds the mean of the swing, not the target.
        mean_off = (found.highest_c - target_c) / (target_c - ambient_c)
        share = 2 * loop.period_s / min(found.on_s, found.off_s) + mean_off
        assert found.hold_percent == pytest.approx(holds_percent, rel=share)
        # Of the lag, a swing shows what it has time for (docs); a level may be wrong by a step.
        on_left, off_left = np.exp(-np.array([found.on_s, found.off_s]) / sense.lag_s)
        shown = (1 - on_left) * (1 - off_left) / (1 - on_left * off_left)
        step_k = controller.sensors[LOOP].step_at_k(target_c, controller.board.mcu)
        blur_s = step_k / found.both + 2 * loop.period_s
        waits_s = process_of(controller, LOOP).late_s
        assert shown * sense.lag_s - blur_s <= found.late_s <= sense.lag_s + waits_s + blur_s


class Found(NamedTuple):
    hold_percent: float
    late_s: float
    both: float
    on_s: float
    off_s: float
    highest_c: float


def measured(log, period_s):
    """What a tuning says of the machine, and the means of its swings."""
    last = log[-1]
    swings = float(last["autotune.cycles"]) - 1
    on_s, off_s = (
        float(last[f"autotune.{each}_sum"]) * period_s / swings for each in ("on", "off")
    )
    return Found(
        hold_percent=float(last["autotune.hold_percent"]),
        late_s=float(last["autotune.lag_s"]) + float(last["autotune.dead_s"]),
        both=float(last["autotune.rise"]) * (1 + on_s / off_s),
        on_s=on_s,
        off_s=off_s,
        highest_c=float(log["temperature_c"].max()),
    )


def test_the_loop_uses_what_was_found():
    found = tuned("extruder", 200.0)
    row = commanded("extruder", found.line, *at({1: "M104 S200"}), {"for": "5 s"}).log[-1]
    assert [row[f"algorithm.{gain}"] for gain in found.gains._fields] == list(found.gains)


def test_a_tuning_can_be_replayed():
    result = replay(example("extruder"), tuned("extruder", 200.0).log)
    assert (result.mismatches, result.unchecked) == (0, ())


# ---- the binaries, tuned by their host ----


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


def test_the_gains_outlive_the_power():
    device = fired("extruder", EXTRUDER[0], {"for": f"{TUNED_S:g} s"}).device
    kp = device.read(f"settings.{LOOP}_kp")
    assert kp != np.float32(example("extruder").loops[LOOP].algorithm.kp)
    device.power_cycle()
    device.advance(device.time_s + 1.0)
    assert device.read(f"settings.{LOOP}_kp") == kp
    assert device.read(f"settings.{LOOP}_setpoint_c") == 0


# ---- the extruder: from cold, and under filament; model and binary ----

OVERSHOOT_K, DIP_K, WITHIN_K, BACK_S = 1.0, 2.0, 0.5, 20.0
"""What the extruder is held to."""
FED_S, STOPPED_S = 200.0, 260.0
MEAN_S = 5.0


@pytest.fixture(scope="module")
def modelled_extruder():
    lines = (*at({1: "M104 S200"}), *at({FED_S: "5 mm/s", STOPPED_S: "0 mm/s"}, "extrude"))
    return commanded("extruder", tuned("extruder", 200.0).line, *lines, {"for": "400 s"})


@pytest.fixture(params=["the model", "the binary"])
def extruder(request, modelled_extruder):
    """What was fed from when on, and when it was switched on."""
    return (modelled_extruder, 1, FED_S) if request.param == "the model" else (
        run_of("extruder"), 1500, 1700
    )  # fmt: skip


def test_the_extruder_keeps_to_what_it_is_held_to(extruder):
    run, on_s, fed_s = extruder
    assert run.between(on_s - 1, on_s)["temperature_c"].max(initial=20.0) < 30
    assert 0 < run.between(on_s, fed_s)["temperature_c"].max() - 200 <= OVERSHOOT_K
    fed, stopped = metrics(run.trace, run.controller).disturbances[:2]
    assert (fed.at_s, fed.what) == (fed_s, "extrude 5 mm/s")
    assert fed.dip_k <= DIP_K
    assert fed.recovered_after_s is not None
    assert fed.recovered_after_s <= BACK_S
    assert stopped.at_s == fed_s + 60
    assert stopped.rise_k <= OVERSHOOT_K
    assert set(run.log["fault.code"]) == {0}


def test_so_does_its_block(modelled_extruder):
    trace = modelled_extruder.trace
    count = round(MEAN_S / trace.times_s[1])
    errors_k = trace.temperatures_c["block"] - 200.0
    means_k = np.convolve(errors_k, np.full(count, 1 / count), "valid")
    times_s = trace.times_s[count - 1 :]
    assert means_k[times_s < FED_S].max() <= OVERSHOOT_K
    assert -errors_k[trace.times_s >= FED_S].min() <= DIP_K
    fed = (times_s >= FED_S + BACK_S) & (times_s < STOPPED_S)
    assert np.abs(means_k[fed]).max() <= WITHIN_K


def test_the_filament_takes_heat(modelled_extruder):
    """5 mm/s · 0.0056 J/(K·mm) · 180 K ≈ 5 W more."""
    trace = modelled_extruder.trace
    on = trace.on_fraction["heater"] * 40
    before = on[(trace.times_s > 150) & (trace.times_s < FED_S)].mean()
    during = on[(trace.times_s > 220) & (trace.times_s < STOPPED_S)].mean()
    assert during - before == pytest.approx(5.04, rel=0.05)


# ---- the feeder: from 180 to 250 °C, with and without its feed ----

FEED_MM_PER_S = 5
HOLD_S, LOOKED_AT_S = 300.0, 120.0
"""Time to heat up and settle, and the part of it that is steady."""
PHASES = [
    (target_c, feeds, 1.0 + HOLD_S * (2 * number + feeds))
    for number, target_c in enumerate(range(180, 251, 10))
    for feeds in (False, True)
]
AIM_K = 0.3
"""What we aim at, at the element itself; what is read of it may be off by half a step of the
converter, 0.13 K, more. The published machine held +0.9 and −0.8 K."""
STEADY = ((600, 180, 0.0), (900, 180, 5.0), (1400, 250, 0.0), (1700, 250, 5.0))
"""Of the binary: from (s, for 100 s), target (°C) and feed (mm/s)."""


@pytest.fixture(scope="module")
def fed():
    feed = f"G1 E{FEED_MM_PER_S * HOLD_S:g} F{60 * FEED_MM_PER_S}"
    lines = at({at_s: feed if feeds else f"M104 S{target_c}" for target_c, feeds, at_s in PHASES})
    end = {"for": f"{PHASES[-1][2] + HOLD_S} s"}
    return commanded("feeder", tuned("feeder", 210.0).line, *at({0.1: "M83"}), *lines, end)


@pytest.mark.parametrize(("target_c", "feeds", "start_s"), PHASES)
def test_the_feeder_is_steady(fed, target_c, feeds, start_s):
    end_s = start_s + HOLD_S
    assert set(fed.between(end_s - LOOKED_AT_S, end_s)["setpoint_c"]) == {target_c}
    half_step_k = fed.controller.sensors[LOOP].step_at_k(target_c, "atmega328p") / 2
    errors_k = fed.between(end_s - LOOKED_AT_S, end_s)["temperature_c"] - target_c
    assert abs(errors_k).max() <= AIM_K + half_step_k
    steady = (fed.trace.times_s > end_s - LOOKED_AT_S) & (fed.trace.times_s < end_s)
    assert abs(fed.trace.sensed_c[LOOP][steady] - target_c).max() <= AIM_K
    moved = fed.trace.fed_mm_per_s[steady].mean()
    assert moved == pytest.approx(FEED_MM_PER_S if feeds else 0.0, abs=0.05)


def test_no_protection_trips_on_the_way(fed):
    assert set(fed.log["fault.code"]) == {0}


@pytest.mark.parametrize(("start_s", "target_c", "feed_mm_per_s"), STEADY)
def test_the_feeders_binary_is_as_steady(start_s, target_c, feed_mm_per_s):
    run = run_of("feeder")
    errors_k = run.between(start_s, start_s + 100)["temperature_c"] - target_c
    assert abs(errors_k).max() <= AIM_K
    inside = (run.trace.times_s > start_s) & (run.trace.times_s < start_s + 100)
    assert run.trace.fed_mm_per_s[inside].mean() == pytest.approx(feed_mm_per_s, rel=0.01)
