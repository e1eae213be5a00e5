"""What the limiter holds, whatever the wire: the root mean square that follows from its duty."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rig.firmware import changed, controller_of

from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.protection.limiter import Limiter
from heatwright.sim.reference.sensors.current import IdealSensor

SUPPLY_V, LIMIT_A, TRIP_A = 43.0, 3.0, 3.75
RATED = {True: 25.57, False: SUPPLY_V}
SMALL = st.floats(0.001, 5.0)
"""Duties whose current is about what counts as one, %."""
ASKED = st.lists(st.one_of(SMALL, st.floats(5.0, 100.0), st.just(100.0)), min_size=8, max_size=40)


class Wire:
    """A wire behind a limiter, measured in each step under the duty of the step before."""

    def __init__(self, ohm: float, *, rated: bool, text: str = "") -> None:
        plain = "fabricator" if rated else changed("fabricator", (", rated: 25.57 V", ""))
        self._controller = controller_of(text or plain)
        self.limiter = Limiter(self._controller, self._controller.loops["nozzle"])
        sensor = self._controller.sensors["current"]
        self._meter = IdealSensor(sensor, self._controller.board)  # type: ignore[arg-type]
        self._full_share = (RATED[rated] / SUPPLY_V) ** 2
        self._peak_a = SUPPLY_V / ohm
        self._duty = 0.0

    @property
    def rms_a(self) -> float:
        """What it has to bear under the present duty."""
        return math.sqrt(self._duty / 100 * self._full_share) * self._peak_a

    @property
    def mean_a(self) -> float:
        return self._duty / 100 * self._full_share * self._peak_a

    def ask(self, percent: float) -> bool:
        """Do a step; True if rule 20 trips in it."""
        _, raw = self._meter.read(self.mean_a)
        self.limiter.measure(raw, Single(self._duty))
        code = self.limiter.watch()
        self._duty = min(percent, float(self.limiter.top_percent))
        return code == 20

    def bound_a(self, held_a: float) -> float:
        """The limit, as far as half a step of the ADC lets the smallest current tell it."""
        half_a = self.limiter.amperes_of.step_a / 2
        return LIMIT_A * (1 + half_a / held_a) * (1 + 1e-6)


@given(asked=ASKED, ohm=st.floats(0.5, 40.0), rated=st.booleans())
def test_no_wire_bears_more_than_the_limit_for_longer_than_a_step(
    asked: list[float], ohm: float, rated: bool
) -> None:
    """It trips, or the step after the first too much has less."""
    wire = Wire(ohm, rated=rated)
    held_a = LIMIT_A**2 / (SUPPLY_V / ohm)
    beyond = 0
    for percent in asked:
        if wire.ask(percent):
            return
        beyond = beyond + 1 if wire.rms_a > wire.bound_a(held_a) else 0
        assert beyond <= 1


@pytest.mark.parametrize("rated", [True, False])
@pytest.mark.parametrize("ohm", [4.0, 6.0, 8.0, 12.0, 30.0])
def test_the_limit_is_used_up(ohm: float, rated: bool) -> None:
    """Asked for all, a wire has full duty or the limit, to what half a step of the ADC tells."""
    wire = Wire(ohm, rated=rated)
    for _ in range(8):
        assert not wire.ask(100.0)
    full_a = RATED[rated] / ohm
    expected_a = min(full_a, LIMIT_A)
    half_a = wire.limiter.amperes_of.step_a / 2
    assert wire.rms_a == pytest.approx(expected_a, rel=1.01 * half_a / wire.mean_a)


@pytest.mark.parametrize("rated", [True, False])
def test_a_duty_too_small_to_be_measured_leaves_the_way_up_open(rated: bool) -> None:
    """A healthy wire goes on from a quarter, after hours of a duty that shows no current."""
    wire = Wire(8.54, rated=rated)
    for _ in range(50):
        wire.ask(0.01)
    duties = []
    for _ in range(5):
        wire.ask(100.0)
        duties.append(float(wire.limiter.top_percent))
    assert duties[0] == 25.0
    assert wire.rms_a == pytest.approx(LIMIT_A, rel=0.01)


def test_a_wire_of_too_little_resistance_trips_in_the_second_step() -> None:
    """Of a fifth: its mean at a quarter of full duty is what 3.75 A have at all of it."""
    for ohm, trips in ((1.65, True), (1.75, False)):
        wire = Wire(ohm, rated=True)
        assert not wire.ask(100.0)
        assert wire.ask(100.0) is trips


@pytest.mark.parametrize("scale", ["38 mV/A", "40 mV/A", "60 mV/A"])
def test_what_check_allows_of_a_coarse_sensor_is_told_from_none(scale: str) -> None:
    """A wire that almost trips is held, and not sent back to its first duty by a low reading."""
    text = changed("fabricator", (", rated: 25.57 V", ""), ("0.5 V/A", scale))
    for ohm in (2.9, 2.95, 3.0, 3.2, 3.5, 4.0):
        wire = Wire(ohm, rated=False, text=text)
        duties = []
        for _ in range(100):
            assert not wire.ask(100.0)
            duties.append(float(wire.limiter.top_percent))
        assert duties[0] == 25.0
        assert max(duties[1:]) < 12.5
