"""What must hold for every sequence of readings, setpoints and keys."""

from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from heatwright.sim.reference import Record, Reference
from heatwright.sim.reference.numbers import Single
from heatwright.spec import Controller, OnOff, Pid

RAW = st.integers(-(2**15), 2**15 - 1)
NEAR = st.integers(18 * 16, 84 * 16)

STEP = st.tuples(
    st.sampled_from([0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5]),
    st.one_of(NEAR, RAW),
    st.sampled_from([10.0, 20.0, 50.0, 69.9, 70.0]),
    st.booleans(),
)
STEPS = st.lists(STEP, min_size=1, max_size=60)

GAINS = st.floats(0, 1e6, allow_subnormal=False)
PERCENT = st.tuples(st.floats(0, 100), st.floats(0, 100)).map(sorted)


@st.composite
def pids(draw: st.DrawFn) -> Pid:
    def limits(bounds: list[float]) -> dict[str, str]:
        return {"minimum": f"{bounds[0]:.3f} %", "maximum": f"{bounds[1]:.3f} %"}

    return Pid.model_validate(
        {
            "kind": "pid",
            "kp": draw(GAINS),
            "ki": draw(GAINS),
            "kd": draw(GAINS),
            "derivative_of": draw(st.sampled_from(["measurement", "error"])),
            "derivative_filter": f"{draw(st.integers(0, 60))} s",
            "integral": limits(draw(PERCENT))
            | {"while_limited": draw(st.sampled_from(["hold", "run"]))},
            "output": limits(draw(PERCENT)),
        }
    )


@st.composite
def on_offs(draw: st.DrawFn) -> OnOff:
    return OnOff.model_validate(
        {
            "kind": "on_off",
            "hysteresis": f"{draw(st.integers(0, 40)) / 8} K",
            "lead": f"{draw(st.integers(0, 60))} s",
            "lead_filter": f"{draw(st.integers(0, 60))} s",
        }
    )


ALGORITHMS = st.one_of(on_offs(), pids())


def run(controller: Controller, steps: list[tuple[int, int, float, bool]]) -> list[Record]:
    reference = Reference(controller, "air")
    return [
        reference.step(status, raw, Single(setpoint), acknowledge=acknowledge)
        for status, raw, setpoint, acknowledge in steps
    ]


@given(algorithm=ALGORITHMS, steps=STEPS)
@settings(deadline=None)
def test_duty_stays_within_its_limits(vary: Any, algorithm: Any, steps: Any) -> None:
    for record in run(vary(algorithm=algorithm), steps):
        assert 0 <= record["duty_percent"] <= 100
        if isinstance(algorithm, Pid) and record["duty_percent"]:
            limits = algorithm.output
            assert record["duty_percent"] >= Single(limits.minimum_percent)
            assert record["duty_percent"] <= Single(limits.maximum_percent)


@given(algorithm=ALGORITHMS, steps=STEPS)
@settings(deadline=None)
def test_no_heat_without_a_reading_or_with_a_fault(vary: Any, algorithm: Any, steps: Any) -> None:
    for record in run(vary(algorithm=algorithm), steps):
        if record["fault.code"] or record["reading_status"]:
            assert record["duty_percent"] == 0


@given(algorithm=ALGORITHMS, steps=STEPS)
@settings(deadline=None)
def test_a_fault_stays_as_it_is_until_acknowledged(vary: Any, algorithm: Any, steps: Any) -> None:
    before: Record | None = None
    for record, (_, _, _, acknowledged) in zip(
        run(vary(algorithm=algorithm), steps), steps, strict=True
    ):
        if before is not None and before["fault.code"] and not acknowledged:
            assert record["fault.code"] == before["fault.code"]
            assert record["fault.temperature_c"] == before["fault.temperature_c"]
        before = record


@given(algorithm=ALGORITHMS, steps=STEPS)
@settings(deadline=None)
def test_too_hot_a_reading_always_ends_in_a_fault(vary: Any, algorithm: Any, steps: Any) -> None:
    for record, (status, raw, _, _) in zip(
        run(vary(algorithm=algorithm), steps), steps, strict=True
    ):
        if status == 0 and raw >= 85 * 16:
            assert record["fault.code"]


@given(algorithm=pids(), steps=STEPS)
@settings(deadline=None)
def test_the_integral_stays_within_its_limits(vary: Any, algorithm: Pid, steps: Any) -> None:
    limits = algorithm.integral
    for record in run(vary(algorithm=algorithm), steps):
        if record.get("algorithm.started"):
            integral = record.get("algorithm.integral", Single(limits.minimum_percent))
            assert Single(limits.minimum_percent) <= integral <= Single(limits.maximum_percent)


@given(algorithm=ALGORITHMS, steps=STEPS)
@settings(deadline=None)
def test_every_member_fits_its_width(vary: Any, algorithm: Any, steps: Any) -> None:
    controller = vary(algorithm=algorithm)
    members = Reference(controller, "air").members
    for record in run(controller, steps):
        assert list(record) == [name for name, _ in members]
        for name, width in members:
            if width == "f4":
                assert isinstance(record[name], np.float32), name
                assert np.isfinite(record[name]), name
            else:
                info = np.iinfo(width)
                assert info.min <= record[name] <= info.max, name


@given(algorithm=ALGORITHMS, steps=STEPS)
@settings(deadline=None)
def test_the_same_inputs_give_the_same_bits(vary: Any, algorithm: Any, steps: Any) -> None:
    controller = vary(algorithm=algorithm)
    assert run(controller, steps) == run(controller, steps)
