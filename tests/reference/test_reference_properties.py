"""What must hold for every sequence of readings, setpoints and keys, and when a host joins in."""

import dataclasses
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_machines import Commanded, Kiln, commanded_of, kiln_of

from heatwright.sim.reference import Record, Reference
from heatwright.sim.reference.inputs import AUTOMATIC
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.programs import state as program
from heatwright.sim.reference.programs.copies import cell_of, column_of, copy_of
from heatwright.sim.reference.programs.program import resumed
from heatwright.sim.replay import replay
from heatwright.spec import Controller, OnOff, Pid

RAW = st.integers(-(2**15), 2**15 - 1)
NEAR = st.integers(18 * 16, 84 * 16)

STEP = st.tuples(
    st.sampled_from([0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5]), st.one_of(NEAR, RAW),
    st.sampled_from([10.0, 20.0, 50.0, 69.9, 70.0]), st.booleans(),
)  # fmt: skip
STEPS = st.lists(STEP, min_size=1, max_size=60)

GAINS = st.floats(0, 1e6, allow_subnormal=False)
PERCENT = st.tuples(st.floats(0, 100), st.floats(0, 100)).map(sorted)
SECONDS = st.integers(0, 60).map("{} s".format)


@st.composite
def pids(draw: st.DrawFn) -> Pid:
    def limits() -> dict[str, str]:
        return dict(zip(("minimum", "maximum"), map("{:.3f} %".format, draw(PERCENT)), strict=True))

    told = {gain: draw(GAINS) for gain in ("kp", "ki", "kd")} | {
        "derivative_of": draw(st.sampled_from(["measurement", "error"])),
        "derivative_filter": draw(SECONDS),
        "derivative_step": draw(st.sampled_from(["present", "previous"])),
        "dead_band": f"{draw(st.integers(0, 16)) / 8} K",
        "dead_band_keeps": draw(st.sampled_from(["integral", "output"])),
        "integral": limits() | {"while_limited": draw(st.sampled_from(["hold", "run"]))},
    }
    return Pid.model_validate({"kind": "pid", **told, "output": limits()})


@st.composite
def on_offs(draw: st.DrawFn) -> OnOff:
    told = {"hysteresis": f"{draw(st.integers(0, 40)) / 8} K", "lead": draw(SECONDS)}
    return OnOff.model_validate({"kind": "on_off", **told, "lead_filter": draw(SECONDS)})


ALGORITHMS = st.one_of(on_offs(), pids())


def run(controller: Controller, steps: list[tuple[int, int, float, bool]]) -> list[Record]:
    reference = Reference(controller, "air")
    return [
        reference.step(status, raw, Single(setpoint), acknowledge=acknowledge)
        for status, raw, setpoint, acknowledge in steps
    ]


@given(algorithm=ALGORITHMS, steps=STEPS)
@settings(max_examples=200)
def test_what_holds_of_every_course(vary: Any, algorithm: OnOff | Pid, steps: Any) -> None:
    """No heat without a reading or with a fault, which lasts; and nothing leaves its limits."""
    controller = vary(algorithm=algorithm)
    records = run(controller, steps)
    for record, (status, raw, _, _) in zip(records, steps, strict=True):
        assert 0 <= record["duty_percent"] <= 100
        if record["fault.code"] or status:
            assert record["duty_percent"] == 0
        if status == 0 and raw >= 85 * 16:
            assert record["fault.code"], "too hot"
        if isinstance(algorithm, Pid):
            limits_hold(algorithm, record)
        widths_hold(controller, record)
    for (before, record), (*_, acknowledged) in zip(pairwise(records), steps[1:], strict=True):
        if before["fault.code"] and not acknowledged:
            for member in ("fault.code", "fault.temperature_c"):
                assert record[member] == before[member]
    assert run(controller, steps) == records, "the same inputs give the same bits"


def limits_hold(algorithm: Pid, record: Record) -> None:
    output, limits = algorithm.output, algorithm.integral
    if record["duty_percent"]:
        assert record["duty_percent"] >= Single(output.minimum_percent)
        assert record["duty_percent"] <= Single(output.maximum_percent)
    if record.get("algorithm.started"):
        integral = record.get("algorithm.integral", Single(limits.minimum_percent))
        assert Single(limits.minimum_percent) <= integral <= Single(limits.maximum_percent)


def widths_hold(controller: Controller, record: Record) -> None:
    members = Reference(controller, "air").members
    assert list(record) == [name for name, _ in members]
    for name, width in members:
        if width == "f4":
            assert isinstance(record[name], np.float32), name
            assert np.isfinite(record[name]), name
        else:
            info = np.iinfo(width)
            assert info.min <= record[name] <= info.max, name


SINGLE = 2**-22  # a few roundings of numbers up to some hundreds, relatively


@given(st.integers(-64, 64), st.integers(-4, 4), st.floats(0, 100, width=32))
def test_the_return_from_manual_does_not_jump(sixteenths: int, slope: int, percent: float) -> None:
    """As long as the integral's limits let it follow."""
    loop = Commanded(commanded_of())
    loop.by_hand(percent)
    base_c = 50 + sixteenths / 16
    records = loop.feed_all([base_c - slope / 16, base_c])
    assert records[-1]["duty_percent"] == Single(percent)
    loop.mode = AUTOMATIC
    before = records[-1]
    inside = 0 < before["algorithm.integral"] < 100
    after = loop.feed(base_c)  # the slope has ended: take its part out of the comparison
    drop = 8 * (float(before["algorithm.derivative"]) - float(after["algorithm.derivative"]))
    expected = percent - drop + 0.5 * -sixteenths / 16
    if inside and 0 < expected < 100:
        assert after["duty_percent"] == pytest.approx(expected, abs=100 * SINGLE)


@given(
    st.lists(st.integers(-32, 32), min_size=2, max_size=5),
    st.floats(0.5, 20, width=32),
    st.floats(0.5, 20, width=32),
)
def test_new_gains_do_not_jump(sixteenths: list[int], kp: float, kd: float) -> None:
    temperatures_c = [50 + n / 16 for n in sixteenths]
    loop = Commanded(commanded_of())
    loop.feed_all(temperatures_c)
    twin = Commanded(commanded_of())
    twin.feed_all(temperatures_c)
    twin.set_gains(kp, 0.5, kd)
    old, new = loop.feed(50.0), twin.feed(50.0)
    inside = 0 < new["algorithm.integral"] < 100 and 0 < old["algorithm.integral"] < 100
    if inside and 0 < old["duty_percent"] < 100:
        assert new["duty_percent"] == pytest.approx(old["duty_percent"], abs=300 * SINGLE)
        assert new["algorithm.kp"] == Single(kp)


def test_a_tunable_loop_needs_its_gains() -> None:
    loop = Commanded(commanded_of())
    loop.gains = None
    with pytest.raises(ValueError, match="gains"):
        loop.feed(45.0)


def test_a_critical_temperature_must_be_told() -> None:
    adjustable = kiln_of(protection="maximum_adjustable: true")
    with pytest.raises(ValueError, match="critical temperature"):
        Reference(adjustable, "air").step(0, 0, Single(0))


_FIRED = (
    "{to: 60 °C, over: 20 s}, {hold: 6 s}, {to: 90 °C, at: as fast as possible}, "
    "{to: 20 °C, at: 6500 K/h}, {hold: until operator}"
)
_WITH = {"average": "moving_average: 3", "algorithm": "ki: 0.1, feed_forward: 20"}
CONTROLLER = kiln_of(_FIRED, **_WITH)
KEEPING = kiln_of(
    _FIRED, **_WITH, programs="on_fault: pause; after_power_loss: {resume_within: 9 K}"
)
LOWEST_C, HIGHEST_C = 0.0, 90.0

READINGS = st.floats(0, 90).map(lambda celsius: round(celsius * 128) / 128)
ORDERS = st.one_of(
    st.tuples(st.sampled_from(["start", "jump"]), st.integers(0, 6)),
    st.tuples(st.sampled_from(["pause", "resume", "skip", "stop"]), st.just(0)),
)
ALL_DEEDS = {"order": ORDERS, "read": READINGS, "follow": st.integers(1, 12)} | dict.fromkeys(
    ("miss", "acknowledge"), st.just(0)
)
EACH = [st.tuples(st.just(deed), what) for deed, what in ALL_DEEDS.items()]
DEEDS = st.lists(st.one_of(EACH), min_size=1, max_size=60)


def done(kiln, deed, what):
    """Do one thing; return the steps that it takes."""
    if deed in ("order", "acknowledge"):
        kiln.order(*what) if deed == "order" else kiln.operator.acknowledge()
        return []
    if deed == "follow":
        return kiln.follow(what) if kiln.record else []
    return [kiln.feed(what) if deed == "read" else kiln.miss()]


def fired(deeds, controller):
    kiln = Kiln(controller)
    assert kiln.order("start", 1)
    records = [kiln.feed(20.0)]
    copies = [kiln.reference.program.copy]
    for deed, what in deeds:
        found = done(kiln, deed, what)
        records += found
        copies += [kiln.reference.program.copy] * len(found)
    return kiln, records, copies


@pytest.mark.parametrize("controller", [CONTROLLER, KEEPING], ids=["ends", "keeps"])
@given(deeds=DEEDS)
@settings(max_examples=200)
def test_what_holds_of_every_program(controller, deeds):
    kiln, records, copies = fired(deeds, controller)
    for record in records:
        heat_is_only_where_it_goes_on(record)
        if record["program.state"] != program.IDLE:
            the_setpoint_keeps_within_its_ends(record)
    for before, record in pairwise(records):
        begun = record["program.order"] == program.START and record["program.clock"] == 0
        if not begun:
            clocks_stand_still_but_while_it_runs(before, record)
    points = controller.programs.points
    dtype = [("time_s", "f8"), *kiln.reference.members, *column_of(points)]
    rows = [
        (float(number), *record.values(), cell_of(copy, points))
        for number, (record, copy) in enumerate(zip(records, copies, strict=True))
    ]
    assert replay(controller, np.array(rows, dtype=dtype)).mismatches == 0


def heat_is_only_where_it_goes_on(record):
    state = record["program.state"]
    goes_on = state in (program.RUNNING, program.RETURNING)
    assert bool(record["enabled"]) == goes_on
    if not goes_on or record["fault.code"] or record["reading_status"]:
        assert record["duty_percent"] == 0
    assert (record["program.waiting"] == 0) or goes_on
    assert state != program.RESTORING


def the_setpoint_keeps_within_its_ends(record):
    now = {name: record[f"program.{name}"] for name in ("elapsed", "length", "segment_clock")}
    assert now["elapsed"] <= now["length"]
    assert now["elapsed"] <= now["segment_clock"] <= record["program.clock"]
    assert LOWEST_C <= record["program.setpoint_c"] <= HIGHEST_C
    assert record["setpoint_c"] == record["program.setpoint_c"]
    assert 1 <= record["program.segment"] <= record["program.segments"]


def clocks_stand_still_but_while_it_runs(before, record):
    moved = int(record["program.clock"]) - int(before["program.clock"])
    assert moved in ({0, 1} if before["program.state"] == program.RUNNING else {0})
    if record["program.state"] in (program.PAUSED, program.INTERRUPTED, program.IDLE):
        assert record["program.energy"] == before["program.energy"]


@pytest.mark.parametrize("otherwise", ["stop", "pause"])
@pytest.mark.parametrize("state", [program.RESTORING, program.PAUSED, program.INTERRUPTED])
@pytest.mark.parametrize("feed", ["near", "far", "none", "stopped", "resumed", "resumed far"])
def test_a_log_of_the_first_step_tells_what_it_found(otherwise, state, feed):
    limit = f"{{resume_within: 30 K, otherwise: {otherwise}}}"
    kiln = Kiln(kiln_of(programs=f"on_fault: pause; after_power_loss: {limit}"))
    kiln.cut(state)
    if feed.startswith(("stopped", "resumed")):
        kiln.order("stop" if feed == "stopped" else "resume")
    found = dataclasses.replace(kiln.reference.program.now)
    record = kiln.miss() if feed == "none" else kiln.feed(100.0 if "far" in feed else 35.0)
    row = np.array([tuple(record.values())], dtype=list(kiln.reference.members))[0]
    again = Kiln(kiln.controller)
    again.reference.program.load(1, copy_of(kiln.controller.programs.stored[0]))
    again.reference.program.restore(resumed(row))
    assert again.reference.program.now.energy == found.energy
    again.operator._program = (record["program.order"], record["program.argument"])
    status = int(record["reading_status"])
    again.step(status, int(record["reading_raw"]))
    assert again.record == record
