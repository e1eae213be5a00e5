"""What no course of a `.txt` can tell of the reference model's parts."""

import math
from importlib import import_module

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference_machines import Kiln, kiln_of
from rig.firmware import EXAMPLE_NAMES, controller_of

from heatwright import spec
from heatwright.sim.reference.algorithms.response import Response
from heatwright.sim.reference.algorithms.tuning_rule import Constants, Swings, found_by
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.outputs.course import Held, course_of
from heatwright.sim.reference.outputs.output import heater_of, pwm_period
from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.registry import module_of


def test_the_sum_is_in_the_order_of_the_slots_and_single():
    """The fourth reading takes the place of the first: (4th + 2nd) + 3rd, times a single 1/3."""
    readings = [np.float32(x) for x in (1000.5078125, 0.0234375, 777.125, 33.3359375)]
    kiln = Kiln(kiln_of(average="moving_average: 3"))
    record = kiln.feed_all([float(x) for x in readings])[-1]
    expected = (readings[3] + readings[1] + readings[2]) * np.float32(1 / 3)
    assert record["temperature_c"] == expected


SENSORS = {
    sensor.kind: (sensor, controller.board)
    for controller in map(controller_of, EXAMPLE_NAMES)
    for sensor in controller.sensors.values()
}


@pytest.mark.parametrize("kind", spec.kinds(spec.Sensor))
def test_every_sensor_can_be_read(kind):
    """What it tells is within a step of what it feels; a sum has as many codes in a step."""
    module = import_module(module_of("sensor", "reference", kind))
    felt = 1.0 if kind == "current" else 50.0
    status, raw = module.IdealSensor(*SENSORS[kind]).read(felt)
    assert status == 0
    codes = getattr(SENSORS[kind][0], "oversample", 1)
    below, found, above = map(module.converter(*SENSORS[kind]), (raw - codes, raw, raw + codes))
    assert abs(found - felt) <= abs(above - below) / 2


@pytest.mark.parametrize(
    ("resolution", "code"), [("9 bit", 808), ("10 bit", 804), ("11 bit", 806), ("12 bit", 805)]
)
def test_ds18b20_rounds_to_its_resolution_and_ends_at_its_range(resolution, code):
    module = import_module("heatwright.sim.reference.sensors.ds18b20")
    told = {"kind": "ds18b20", "pin": "A1", "resolution": resolution}
    sensor = module.IdealSensor(module.Ds18b20.model_validate(told), spec.BOARDS["mega2560"])
    assert sensor.read(50.32) == (0, code)
    assert (sensor.read(-60.0), sensor.read(200.0)) == ((0, -880), (0, 2000))


# ---- the rule of tuning finds what a relay's swing is made of: an integrator, a lag, a dead time

PERIOD_S = 0.1
SINGLE = 2**-20  # roundings to single precision, relatively
DAMPED = 5
"""Lags in each half of a swing after which the turn before it is forgotten: e⁻⁵ is below 1 %."""
PADE = 0.065  # how far the share of the top is from the exact one, up to five times the fall (docs)


def constants(**changes):
    numbers = {"period_s": PERIOD_S, "swing_percent": 100, "filter_s": 1, "least_s": 1.35 * 1.1}
    singles = {name: Single(each) for name, each in (numbers | {"start_percent": 0}).items()}
    wide = (Single(0), Single(100))
    return Constants(**{**singles, "band_k": None, "limits_percent": wide, **changes})


def swung(rise, fall, lag_s, dead_s, on_s):
    """Return what is measured of a steady swing of an integrator behind a lag and a dead time. In
    closed form: the block x is a triangle, from 0 to rise · on. Of τ·dy/dt = x − y remains, t after
    the relay has switched on, y = rise · (t − τ) + A · exp(−t/τ), and t after it has switched off y
    = x_high − fall · (t − τ) + B · exp(−t/τ); A and B make it periodic."""
    off_s = on_s * rise / fall
    on_left, off_left = math.exp(-on_s / lag_s), math.exp(-off_s / lag_s)
    both = (rise + fall) * lag_s / (1 - on_left * off_left)
    after_on, after_off = both * (1 - off_left), -both * (1 - on_left)
    high_c = rise * on_s

    def rising(t):
        return rise * (t - lag_s) + after_on * math.exp(-t / lag_s)

    def falling(t):
        return high_c - fall * (t - lag_s) + after_off * math.exp(-t / lag_s)

    top_c = high_c - fall * lag_s * math.log(-after_off / (fall * lag_s))  # where dy/dt = 0
    off_at_c, on_at_c = rising(on_s - dead_s), falling(off_s - dead_s)
    steps = (on_s / PERIOD_S, off_s / PERIOD_S)
    return Swings(*map(Single, (1.0, *steps, off_at_c - on_at_c, top_c - off_at_c, rise)))


speeds = st.floats(0.3, 3.0)


@given(speeds, st.floats(0.2, 5.0), st.floats(0.5, 6.0), st.floats(0.0, 6.0))
def test_lag_and_dead_time_are_told_apart(rise, ratio, lag_s, dead_s):
    """`ratio` is that of rise to fall; both halves are long enough to forget the turn before."""
    shortest_s = DAMPED * lag_s + dead_s
    on_s = max(shortest_s, shortest_s / ratio)
    found = found_by(swung(rise, rise / ratio, lag_s, dead_s, on_s), constants())
    late_s = lag_s + dead_s
    left = 2 * lag_s * math.exp(-DAMPED) + SINGLE * on_s
    assert float(found.lag_s) + float(found.dead_s) == pytest.approx(late_s, abs=left)
    share = 3 * ratio / (4 * ratio + 6)
    assert found.lag_s == pytest.approx(lag_s, abs=(PADE * lag_s + 2 * left) / (1 - share))


@given(speeds, speeds, st.floats(0.5, 6.0), st.floats(0.3, 5.0))
def test_a_short_swing_makes_the_lag_shorter_never_longer(rise, fall, lag_s, lags):
    """Where the swing is too quick to forget its last turn, less lag is found: less derivative."""
    found = found_by(swung(rise, fall, lag_s, 0.0, lags * lag_s), constants())
    assert float(found.lag_s) + float(found.dead_s) <= lag_s * (1 + 50 * SINGLE)


SWING_K = 1.6 * 12.0 - 2.4 * 5.0
TOP_K = 3 * 1.6 / (4 * 1.6 + 6 * 0.8) * 1.6 * 5.0
FOUR = Swings(*map(Single, (4.0, 480, 960, 4 * SWING_K, 4 * TOP_K, 1.6)))
"""1.6 K/s up, 0.8 down at 100 %: 0.024 K/s per %; on for 12 s, late by 5 s without a dead time."""


def test_the_gains_are_skogestads():
    found = found_by(FOUR, constants())
    assert found.hold_percent == pytest.approx(100 / 3)
    assert (found.lag_s, found.dead_s) == (pytest.approx(5.0, rel=1e-5), pytest.approx(0, abs=1e-5))
    gain = 1 / (0.024 * 0.35 * 5.0)
    assert found.kd == pytest.approx(gain * 5.0, rel=1e-5)
    assert found.integral_minimum == pytest.approx(100 / 3 - 12)
    assert found.integral_maximum == pytest.approx(50)
    # The way down to the setpoint: 100 % and the derivative's share, of which it lacks a third.
    slow_s = max(10, (100 + gain * 5.0 * 1.6) / (100 / 3)) * 0.35 * 5.0
    assert found.ki == pytest.approx(gain / slow_s, rel=1e-5)
    assert found.kp == pytest.approx(gain * (1 + 5.0 / slow_s), rel=1e-5)


@pytest.mark.parametrize("limits", [(25, 40), (0, 30), (60, 80), (-20, 10)])
def test_the_limits_that_it_proposes_are_within_those_there_are(limits):
    least, most = map(Single, limits)
    found = found_by(FOUR, constants(limits_percent=(least, most)))
    assert found.integral_minimum == pytest.approx(min(max(100 / 3 - 12, least), most))
    assert found.integral_maximum == pytest.approx(min(max(50, least), most))


@pytest.mark.parametrize(
    ("band_k", "start_percent", "ratio"),
    [(None, 0.0, 10.0), (10.0, 0.0, 10.0), (10.0, 20.0, 17.857142857), (10.0, 34.0, 40.0),
     (40.0, 20.0, 20.285714286)],
)  # fmt: skip
def test_the_integral_gains_on_the_way_what_it_lacks(band_k, start_percent, ratio):
    changes = {"start_percent": Single(start_percent)}
    found = found_by(FOUR, constants(band_k=band_k and Single(band_k), **changes))
    quick_s = 0.35 * 5.0
    gain = 1 / (0.024 * quick_s)
    assert gain / float(found.ki) / quick_s == pytest.approx(ratio, rel=1e-4)


def pwm(**settings):
    basic = {"kind": "pwm", "pin": "D3", "power": "240 W", "frequency": "490 Hz"}
    return spec.PwmOutput.model_validate(basic | settings)


def test_one_prescaler_serves_all_outputs_of_a_timer(vary):
    """Only pulses that interrupts make have a least length."""
    assert pwm_period(vary(output=pwm(pin="D9")), "heater") == (32653, 0)
    controller = vary(output=pwm(pin="D3", frequency="122 Hz"))
    assert pwm_period(controller, "heater") == (16393, 100)
    outputs = {**controller.outputs, "second": pwm(pin="D4", frequency="30 Hz")}
    both = controller.model_copy(update={"outputs": ReadOnlyDict(outputs)})
    assert (pwm_period(both, "heater"), pwm_period(both, "second")) == ((2049, 13), (8333, 13))


def test_pulses_by_interrupts_are_not_shorter_than_they_are_late(vary):
    heater = heater_of(vary(output=pwm(pin="D4", frequency="500 Hz")), "heater")
    wanted = {0: 0, 2.4: 0, 2.496: 0, 2.5: 800, 50: 16000, 97.5: 31200, 97.504: 32000, 97.6: 32000}
    found = {}
    for duty in wanted:
        heater.apply(Single(duty))
        found[duty] = heater.counts
    assert found == wanted


ORDERS = st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), max_size=200)
"""Asked, permitted, and stopped, in each tick."""


def levels(held: Held, orders: list[tuple[bool, bool, bool]]) -> list[bool]:
    found = []
    for asked, permitted, stopped in orders:
        found.append(held.tick(permitted=permitted))
        held.set(asked=asked)
        if stopped:
            held.stop()
    return found


@given(ORDERS, st.integers(0, 20), st.integers(0, 20))
def test_it_is_never_on_or_off_for_less_than_the_minimum(orders, minimum_on, minimum_off):
    """But for what is not permitted or stopped, which is off at once."""
    on_in_tick = levels(Held(minimum_on, minimum_off), orders)
    for on, (_, permitted, _) in zip(on_in_tick, orders, strict=True):
        assert permitted or not on
    pauses = "".join("10"[not on] for on in on_in_tick).split("1")[:-1]
    assert all(len(pause) >= minimum_off for pause in pauses[1:] if pause)
    assert not pauses or len(pauses[0]) >= minimum_off - 1  # the tick that switches is its end
    free = levels(Held(minimum_on, minimum_off), [(asked, True, False) for asked, *_ in orders])
    pulses = "".join("10"[not on] for on in free).split("0")[:-1]
    assert all(len(pulse) >= minimum_on for pulse in pulses if pulse)


def test_an_output_with_minimum_times_has_such_a_course(vary):
    told = {"kind": "digital", "pin": "D3", "power": "240 W", "minimum_on": "2 s"}
    run = course_of(vary(output=spec.DigitalOutput.model_validate(told)), "heater")
    run.apply(1)
    run.advance(1_000_000)
    run.apply(0)
    assert run.advance(3_000_000) == pytest.approx(1_010_000)


class Course:
    """A loop that is measured; its period is half a second, so 5 s are 10 steps."""

    def __init__(self) -> None:
        self.response = Response(2.0, 5.0, spec.Loop.model_construct(period_s=0.5))

    def go(self, setpoint_c: float, *temperatures_c: float | None, held: bool = True) -> None:
        for each in temperatures_c:
            temperature_c = None if each is None else Single(each)
            self.response.step(temperature_c, Single(setpoint_c), held=held)

    def __getitem__(self, name: str) -> float:
        names = [name for name, _ in self.response.members]
        return float(dict(zip(names, self.response.values(), strict=True))[name])

    @property
    def result(self) -> tuple[float, float, float]:
        return self["measured"], self["settling_s"], self["overshoot_k"]


@pytest.fixture
def course() -> Course:
    return Course()


COURSES = {
    # It is near for good five steps behind the first.
    "a step up that overshoots": [
        (100, [20, 60, 99, 103.5, 104.25, 101, *9 * [99.5]], 2, (0, 0, 0)),
        (100, [99.5], 3, (1, 2.5, 4.25)), (100, [200], 3, (1, 2.5, 4.25)),
    ],
    "a step down counts what is below": [
        (50, [52, *10 * [51]], 3, (1, 0, 0)),
        (40, [51, 45, 37.5, 38, *10 * [42]], 3, (2, 1.5, 2.5)),
    ],
    "the edge is inside": [(50, 11 * [48], 3, (1, 0, 0)), (60, 11 * [57.9], 1, (1, 0, 0))],
    # It reads ahead of the setpoint at the ramp's end, and yet rises.
    "a ramp is approached from where it comes": [
        *((setpoint_c, [setpoint_c + 3], 1, (0, 0, 0)) for setpoint_c in range(20, 101)),
        (100, [103.5, *11 * [101]], 3, (1, 1.0, 3.5)),
    ],
    "missing readings take their time": [
        (50, [20, None, None, 50, *4 * [None], *5 * [50]], 2, (0, 0, 0)),
        (50, [50], 3, (1, 1.5, 0)),
    ],
}  # fmt: skip
"""Setpoint and readings; then the state and the result."""


@pytest.mark.parametrize("what", COURSES)
def test_settling_and_overshoot(course: Course, what: str) -> None:
    for setpoint_c, temperatures_c, state, result in COURSES[what]:
        course.go(setpoint_c, *temperatures_c)
        assert (course["state"], course.result) == (state, result)


def test_what_is_not_held_gives_no_result(course: Course) -> None:
    course.go(50, 20, 50, 50)
    course.go(50, 50, held=False)
    assert course["state"] == 0
    course.go(50, *10 * [50])
    assert course.result == (0, 0, 0)
    course.go(60, 51)
    course.go(70, 51)
    assert (course["state"], course["target_c"], course.result) == (1, 70, (0, 0, 0))


def test_nobody_waits_for_ever(course: Course) -> None:
    course.go(50, *70_000 * [20.0])
    assert course["steps"] == 65535
    course.go(50, *20 * [50.0])
    assert course.result == (0, 0, 0)
