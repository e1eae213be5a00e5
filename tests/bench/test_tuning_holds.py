"""Tuning on the machine itself: what it finds must be robust on any machine, and good on ours."""

from typing import NamedTuple

import numpy as np
import pytest
from machines import PLANTS, example, run, scaled, tuned

from heatwright.sim.replay import replay
from heatwright.sim.tuning.gains import Gains
from heatwright.sim.tuning.margins import margins
from heatwright.sim.tuning.process import process_of

TARGETS = {"extruder": 200.0, "feeder": 210.0}
DONE = 2

LEAST_GAIN_MARGIN = 2.0
LEAST_PHASE_MARGIN_DEG = 45.0
"""What the extruder and the feeder are held to."""


@pytest.mark.parametrize(("capacity", "resistance"), PLANTS)
@pytest.mark.parametrize("name", TARGETS)
class TestOnAnyMachine:
    def test_it_comes_to_an_end_without_a_fault(self, name, capacity, resistance):
        found = tuned(name, TARGETS[name], capacity, resistance)
        assert found.log["autotune.result"].max() == DONE
        assert set(found.log["fault.code"]) == {0}
        assert found.log["temperature_c"].max() < TARGETS[name] + 20

    def test_the_loop_is_robust(self, name, capacity, resistance):
        controller = scaled(example(name), capacity, resistance)
        loop = controller.loops["nozzle"]
        gains = tuned(name, TARGETS[name], capacity, resistance).gains
        found = margins(
            process_of(controller, "nozzle"),
            Gains(*map(float, gains), loop.algorithm.derivative_filter_s),
            loop.period_s,
        )
        assert found.stable
        assert found.gain >= LEAST_GAIN_MARGIN
        assert found.phase_deg >= LEAST_PHASE_MARGIN_DEG

    def test_it_finds_the_machine(self, name, capacity, resistance):
        controller = scaled(example(name), capacity, resistance)
        target_c, loop = TARGETS[name], controller.loops["nozzle"]
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
        step_k = controller.sensors["nozzle"].step_at_k(target_c, controller.board.mcu)
        blur_s = step_k / found.both + 2 * loop.period_s
        waits_s = process_of(controller, "nozzle").late_s
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
        float(last[f"autotune.{half}_sum"]) * period_s / swings for half in ("on", "off")
    )
    rise = float(last["autotune.rise"])
    return Found(
        float(last["autotune.hold_percent"]),
        float(last["autotune.lag_s"]) + float(last["autotune.dead_s"]),
        rise * (1 + on_s / off_s),
        on_s,
        off_s,
        float(log["temperature_c"].max()),
    )


def test_the_loop_uses_what_was_found():
    found = tuned("extruder", 200.0)
    log = run(example("extruder"), found.line, {"at": "1 s", "send": "M104 S200"}, {"for": "5 s"})
    row = log.steps["nozzle"][-1]
    assert [row[f"algorithm.{gain}"] for gain in found.gains._fields] == list(found.gains)


def test_a_tuning_can_be_replayed():
    result = replay(example("extruder"), tuned("extruder", 200.0).log)
    assert (result.mismatches, result.unchecked) == (0, ())
