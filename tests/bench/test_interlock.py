"""Heater and cooler at their pins: one cycle together is seen."""

from types import SimpleNamespace

import numpy as np
import pytest

from heatwright.sim.interlock import Interlock
from heatwright.sim.native.pins import PIN_EVENT, pin_number

CLOCK_HZ = 1_000_000
H, C = "PD5", "PD6"
CUT = [(10, H, 1), (15, H, 0), (20, C, 1), (25, H, 1), (26, C, 0)]


def watch(active="high"):
    heater, cooler = SimpleNamespace(pin=H, active="high"), SimpleNamespace(pin=C, active=active)
    return Interlock(heater, cooler, CLOCK_HZ)


def feed(watched, *changes):
    rows = [(cycle, pin_number(pin), level) for cycle, pin, level in changes]
    watched.feed(np.array(rows, PIN_EVENT), None)


@pytest.mark.parametrize(
    ("active", "batches", "together"),
    [
        ("high", [[(10, H, 1), (20, H, 0), (20, C, 1), (30, C, 0)]], None),
        ("high", [[(10, H, 1), (20, C, 1), (21, H, 0), (30, C, 0)]], 20),  # a single cycle
        ("high", [[(10, H, 1), (20, C, 1)]], 20),  # until the end
        ("low", [[(5, C, 1), (10, H, 1)]], None),
        ("low", [[(5, C, 1), (10, H, 1), (20, C, 0)]], 20),
        ("high", [[(10, H, 1), (20, "PB0", 1), (30, H, 0)]], None),  # another pin
        *(("high", [CUT[:at], CUT[at:]], 25) for at in range(5)),  # wherever the reading is cut
    ],
)
def test_only_together_is_seen(active, batches, together):
    found = watch(active)
    for batch in batches:
        feed(found, *batch)
    assert found.overlap_s == (together and pytest.approx(together / CLOCK_HZ))


def test_a_loss_of_power_is_off():
    found = watch()
    feed(found, (10, H, 1))
    found.power_on(1.0)
    feed(found, (5, C, 1))
    assert found.overlap_s is None
    feed(found, (50, H, 1))
    assert found.overlap_s == pytest.approx(1 + 50 / CLOCK_HZ)
