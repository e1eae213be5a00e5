"""A fan and its tachometer: edges to the cycle, from the speed that a first-order lag has."""

from itertools import pairwise
from math import exp

import numpy as np
import pytest
from rig.firmware import CLOCK_HZ, running

from heatwright.sim.avr import Avr
from heatwright.sim.native.fan import Fan
from heatwright.sim.native.relay import Wire

FULL_HZ, LAG_S = 200.0, 0.5
LATE = 4  # cycles that an instruction may take to end
SWITCHED = """
    DDRD = _BV(PD2); PORTD = _BV(PD3); for (;;) {
        PORTD |= _BV(PD2); for (uint8_t i = 0; i < 40; i++) _delay_ms(50);
        PORTD &= ~_BV(PD2); for (uint8_t i = 0; i < 40; i++) _delay_ms(50);
    }"""
ON = "DDRD = _BV(PD2); PORTD = _BV(PD2) | _BV(PD3);"


def fan_of(source: str) -> tuple[Avr, Fan]:
    avr = running(source)
    fan = Fan(avr, "PD2", "PD3", active_high=True, full_hz=FULL_HZ, lag_s=LAG_S)
    avr.pins.watch("PD3")
    return avr, fan


def test_it_follows_its_line_with_a_lag_and_makes_the_pulses_of_its_speed() -> None:
    avr, fan = fan_of(SWITCHED)
    motor, line = (8 * 3 + bit for bit in (2, 3))
    avr.run(6.0)
    events = avr.pins.take()
    events = events[np.isin(events["pin"], (motor, line))]
    switched = [int(each["cycle"]) for each in events if each["pin"] == motor]
    assert len(switched) >= 4  # floating, on, off, on
    speed_hz, pulses, made = 0.0, 0.0, 0
    for begin, end in pairwise([*switched, avr.cycle]):
        on = bool(events[(events["pin"] == motor) & (events["cycle"] == begin)]["state"][0] & 1)
        target_hz = FULL_HZ if on else 0.0
        rising = events[(events["pin"] == line) & (events["state"] & 1 == 1)]["cycle"]
        for cycle in map(int, rising[(rising > begin) & (rising <= end)]):
            s = (cycle - begin) / CLOCK_HZ
            lost = 1 - exp(-s / LAG_S)
            done = pulses + target_hz * s + (speed_hz - target_hz) * LAG_S * lost
            now_hz = target_hz + (speed_hz - target_hz) * (1 - lost)
            assert done == pytest.approx(made + 0.5, abs=(now_hz + 1) * (LATE + 1) / CLOCK_HZ)
            made += 1
        lost = 1 - exp(-(end - begin) / CLOCK_HZ / LAG_S)
        pulses += target_hz * (end - begin) / CLOCK_HZ + (speed_hz - target_hz) * LAG_S * lost
        speed_hz += (target_hz - speed_hz) * lost
    assert switched[0] < switched[-1]
    assert 500 < made == pytest.approx(pulses, abs=1)
    assert fan.pulses_hz == pytest.approx(speed_hz)


def test_a_steady_speed_has_even_pulses_of_its_share() -> None:
    avr, fan = fan_of(ON)
    for low_share in (0.5, 0.4, 0.6):
        fan.fail(low_share=low_share)
        avr.run(10.0)
        avr.pins.take()
        avr.run(1.0)
        events = avr.pins.take()
        rises = events["cycle"][events["state"] & 1 == 1].astype(np.int64)
        falls = events["cycle"][events["state"] & 1 == 0].astype(np.int64)
        assert np.abs(np.diff(rises) - CLOCK_HZ / FULL_HZ).max() <= LATE + 1
        first = int(rises[0] < falls[0])
        low = (rises[first:] - falls[: len(rises) - first]) * FULL_HZ / CLOCK_HZ
        assert low == pytest.approx(np.full(len(low), low_share), abs=1e-3)


def test_what_is_broken_shows_at_its_line() -> None:
    avr, fan = fan_of(ON)
    avr.run(3.0)
    for how, rises, stands in (
        ({"pace": 0.0}, 0, None), ({"wire": Wire.TORN}, 0, True),
        ({"wire": Wire.SHORTED}, 0, False), ({"noise_hz": 400.0}, 400, None),
        ({"pace": 0.25}, 50, None), ({"wire": Wire.TORN, "noise_hz": 400.0}, 0, True),
    ):  # fmt: skip
        fan.fail(**how)  # type: ignore[arg-type]
        avr.run(0.001)
        avr.pins.take()
        avr.run(1.0)
        events = avr.pins.take()
        found = np.count_nonzero((events["pin"] == 27) & (events["state"] & 1))
        assert found == pytest.approx(rises, abs=1)
        assert stands in {None, avr.pins.level("PD3")}
        fan.fail()
        avr.run(4.0)
        assert fan.pulses_hz == pytest.approx(FULL_HZ, rel=1e-3)


def test_there_are_only_so_many_fans_and_pins() -> None:
    avr, _ = fan_of(ON)
    with pytest.raises(ValueError, match="no pin"):
        Fan(avr, "PD2", "PL3", active_high=True, full_hz=FULL_HZ, lag_s=LAG_S)
    for _ in range(3):
        Fan(avr, "PB0", "PB1", active_high=True, full_hz=FULL_HZ, lag_s=LAG_S)
    with pytest.raises(ValueError, match="too many fans"):
        Fan(avr, "PB0", "PB1", active_high=True, full_hz=FULL_HZ, lag_s=LAG_S)
