"""Loops under a master: their logs replay, the binary's as the model's, and nothing else does."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from machines import events, example

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.replay import ReplayError, replay
from heatwright.spec import load

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"


def written(at_s, **values):
    """A line of a scenario; `air__setpoint` is the name `air.setpoint`."""
    names = {name.replace("__", "."): value for name, value in values.items()}
    return {"at": f"{at_s} s", "write": names}


DRYER = events(
    written(2, air__setpoint="50 °C", air__enabled=True),
    written(10, air__manual_duty="30 %"),
    written(12, air__manual=True),
    written(20, air__manual_duty="60 %"),
    written(25, air__manual=False),
    written(30, air__kp=30.0, air__ki=0.1, air__kd=100.0),
    written(40, air__setpoint="81 °C"),  # refused: too high
    written(41, air__setpoint="60 °C"),
    written(50, air__enabled=False),
    written(55, air__manual=True),  # refused: off
    written(56, air__tune=True),  # refused: off
    written(60, air__enabled=True),
    written(65, air__tune=True),
    written(67, air__setpoint="55 °C"),  # refused: another target
    written(68, air__setpoint="60 °C"),
    written(80, air__tune=False),
    written(90, air__enabled=True),
    written(100, air__tune=True),
    written(110, air__enabled=False),
    {"for": "120 s"},
)
SEEN = ("mode", "enabled", "autotune.result", "autotune.starts", "setpoint_c", "manual_percent",
        "algorithm.kp", "fault.code")  # fmt: skip
REFUSED_AT_S = (40, 55, 56, 67)

FABRICATOR = events(
    written(1, nozzle__setpoint="60 °C", nozzle__enabled=True),
    written(20, nozzle__setpoint="30 °C"),
    written(40, nozzle__setpoint="300 °C"),
    written(50, nozzle__enabled=False),
    {"for": "55 s"},
)
INPUTS = {"reading_raw", "enabled", "current.raw"}
"""What a flipped bit may leave without a difference."""


@pytest.fixture(scope="module")
def log():
    return bench(example("fabricator"), ReferenceDevice(example("fabricator")), FABRICATOR).steps[
        "nozzle"
    ]


@pytest.fixture(scope="module")
def dryers(tmp_path_factory):
    """Binary and model, told the same."""
    folder = tmp_path_factory.mktemp("dryer")
    write(render(plan_firmware(load(EXAMPLES / "dryer.yaml"))), folder)
    device = AvrDevice(example("dryer"), build(folder).elf)
    binary = bench(example("dryer"), device, DRYER).steps["air"]
    model = bench(example("dryer"), ReferenceDevice(example("dryer")), DRYER).steps["air"]
    return device, binary, model


def course(log):
    """What a host sees, each time something of it changes."""
    rows = [tuple(log[name][row].item() for name in SEEN) for row in range(len(log))]
    return [row for row, before in zip(rows, [None, *rows], strict=False) if row != before]


def test_the_binary_is_the_model_bit_for_bit(dryers):
    _, binary, _ = dryers
    result = replay(example("dryer"), binary)
    assert (result.ticks, result.mismatches, result.segments) == (len(binary), 0, 1)


def test_the_binary_takes_and_refuses_what_the_model_does(dryers):
    _, binary, model = dryers
    assert course(binary) == course(model)
    assert {row[0] for row in course(model)} == {0, 1, 2}


def test_the_master_is_told_what_was_refused(dryers):
    device, _, _ = dryers
    refused = [(int(each.time_s), each.exception) for each in device.master.refusals]
    assert refused == [(at_s, 3) for at_s in REFUSED_AT_S]


def test_everything_occurs(log):
    assert set(log["cooling"]) == set(log["algorithm.cooling"]) == {0, 1}
    assert {0, 25, 50, 75, 100} <= set(log["duty_percent"])
    assert set(log["enabled"]) == {0, 1}


def test_its_own_steps_are_equal(log):
    result = replay(example("fabricator"), log)
    assert (result.ticks, result.mismatches, result.segments) == (len(log), 0, 1)
    assert result.first == result.restored == result.unchecked == ()


def test_two_resets_are_three_runs(log):
    result = replay(example("fabricator"), np.concatenate([log, log, log[:100]]))
    assert (result.mismatches, result.segments) == (0, 3)


@given(data=st.data())
@settings(deadline=None, max_examples=60)
def test_any_flipped_bit_of_what_follows_is_seen(log, data):
    row = data.draw(st.integers(1, len(log) - 1))
    names = set(log.dtype.names) - {"time_s", "setpoint_c", "reading_status", *INPUTS}
    member = data.draw(st.sampled_from(sorted(names)))
    broken = log[: row + 20].copy()
    cell = broken[member][row : row + 1].view(np.uint8)
    bit = data.draw(st.integers(0, 8 * len(cell) - 1))
    cell[bit // 8] ^= 1 << bit % 8
    assert replay(example("fabricator"), broken).mismatches


def test_a_lost_master_does_not_explain_a_fault_of_a_loop_that_is_off(log):
    row = int(np.flatnonzero((log["enabled"] == 0) & (log["steps"] > 10))[0])
    broken = log[: row + 1].copy()
    broken["fault.code"][row] = 23
    broken["fault.temperature_c"][row] = broken["temperature_c"][row]
    broken["cooling"][row] = broken["temperature_c"][row] >= 50
    assert replay(example("fabricator"), broken).mismatches


@pytest.mark.parametrize("member", ["enabled", "current.raw", "cooling"])
def test_a_log_must_have_them(log, member):
    names = [name for name in log.dtype.names if name != member]
    with pytest.raises(ReplayError, match=f"lacks {member}"):
        replay(example("fabricator"), log[names])
