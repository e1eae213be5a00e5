"""Heater and cooler at their pins: one cycle together is seen."""

from dataclasses import dataclass

import numpy as np
import pytest

from heatwright.sim.interlock import Interlock
from heatwright.sim.native.pins import PIN_EVENT, pin_number

CLOCK_HZ = 1_000_000
HEATER, COOLER = "PD5", "PD6"


@dataclass(frozen=True)
class Pin:
    pin: str
    active: str = "high"


def events(*changes):
    return np.array([(cycle, pin_number(pin), level) for cycle, pin, level in changes], PIN_EVENT)


def watch(cooler_active="high"):
    return Interlock(Pin(HEATER), Pin(COOLER, cooler_active), CLOCK_HZ)


def fed(*batches, **active):
    found = watch(**active)
    for batch in batches:
        found.feed(events(*batch), None)
    return found.overlap_s


def test_one_after_the_other_is_well():
    assert fed([(10, HEATER, 1), (20, HEATER, 0), (20, COOLER, 1), (30, COOLER, 0)]) is None


def test_a_single_cycle_is_seen():
    found = fed([(10, HEATER, 1), (20, COOLER, 1), (21, HEATER, 0), (30, COOLER, 0)])
    assert found == pytest.approx(20 / CLOCK_HZ)


@pytest.mark.parametrize("cut", range(5))
def test_it_is_seen_wherever_the_reading_is_cut(cut):
    changes = [(10, HEATER, 1), (15, HEATER, 0), (20, COOLER, 1), (25, HEATER, 1), (26, COOLER, 0)]
    assert fed(changes[:cut], changes[cut:]) == pytest.approx(25 / CLOCK_HZ)


def test_together_until_the_end_is_seen():
    assert fed([(10, HEATER, 1), (20, COOLER, 1)]) == pytest.approx(20 / CLOCK_HZ)


def test_a_low_active_cooler_is_on_when_it_is_low():
    assert fed([(5, COOLER, 1), (10, HEATER, 1)], cooler_active="low") is None
    found = fed([(5, COOLER, 1), (10, HEATER, 1), (20, COOLER, 0)], cooler_active="low")
    assert found == pytest.approx(20 / CLOCK_HZ)


def test_other_pins_do_not_matter():
    assert fed([(10, HEATER, 1), (20, "PB0", 1), (30, HEATER, 0)]) is None


def test_a_loss_of_power_is_off():
    found = watch()
    found.feed(events((10, HEATER, 1)), None)
    found.power_on(1.0)
    found.feed(events((5, COOLER, 1)), None)
    assert found.overlap_s is None
    found.feed(events((50, HEATER, 1)), None)
    assert found.overlap_s == pytest.approx(1 + 50 / CLOCK_HZ)
