"""The binaries themselves, on their machines: every step is the model's, bit for bit."""

import numpy as np
import pytest
from bench_runs import REFUSED_AT_S, RUNS, run_of
from machines import course, modelled

from heatwright.sim.replay import replay

GAINS = tuple(f"algorithm.{gain}" for gain in ("kp", "ki", "kd"))
PROGRAM = tuple(
    f"program.{name}"
    for name in ("state", "ended", "number", "segment", "order", "argument", "leap", "kind")
)
COMMANDED = ("mode", "setpoint_c", "manual_percent", "autotune.starts", "fault.code", *GAINS)
SEEN = {
    "dryer": (*COMMANDED, "enabled", "autotune.result"),
    "extruder, ordered about": (*COMMANDED, "fault.acknowledgements"),
    **{name: PROGRAM for name, (example, _) in RUNS.items() if example in {"kiln", "kiln_uno"}},
}
SHORT = ("dryer", "kiln, ordered about", "extruder, ordered about")
LONG = [name for name in RUNS if name not in SHORT]


def assert_models(name):
    found = run_of(name)
    result = replay(found.controller, found.log)
    assert (result.mismatches, result.segments, result.restored) == (0, 1, ())
    assert result.ticks == len(found.log)
    assert set(np.diff(found.log["steps"].astype(int))) == {1}
    assert set(found.log["fault.code"]) == ({0, 19} if name == "extruder, ordered about" else {0})


@pytest.mark.parametrize("name", SHORT)
def test_every_step_is_the_models(name):
    assert_models(name)


@pytest.mark.parametrize("name", LONG)
def test_every_step_of_a_long_run_is_the_models(name):
    assert_models(name)


def assert_obeys(name):
    example, lines = RUNS[name]
    model = modelled(example, *lines).log
    assert course(run_of(name).log, *SEEN[name]) == course(model, *SEEN[name])


@pytest.mark.parametrize("name", SHORT)
def test_it_takes_and_refuses_what_the_model_does(name):
    assert_obeys(name)


@pytest.mark.parametrize("name", [name for name in LONG if name in SEEN])
def test_so_it_does_in_a_long_run(name):
    assert_obeys(name)


def test_the_master_is_told_what_was_refused():
    refused = run_of("dryer").device.master.refusals
    assert [(int(each.time_s), each.exception) for each in refused] == [
        (at_s, 3) for at_s in REFUSED_AT_S
    ]
    assert set(run_of("dryer").log["mode"]) == {0, 1, 2}
