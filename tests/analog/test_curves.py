"""The curve that a simulated sensor's voltage is taken from is its circuit, to a hair of a code."""

import numpy as np
import pytest
from rig import analog_specs
from rig.analog_specs import CIRCUITS

from heatwright.sim.circuits import Wiring, pin_v
from heatwright.sim.sensors.adc_sensor import ABOVE_K, BELOW_K, PER_K, curve_of

CODE_MV = 1000 * 5 / 1024
SPOILT = {
    "sound": Wiring(),
    "corroded": Wiring(series_ohm=100.0),
    "leaking": Wiring(parallel_ohm=10e3),
    "opened": Wiring(opened=True),
    "shorted": Wiring(shorted=True),
}


@pytest.mark.parametrize("wiring", SPOILT)
@pytest.mark.parametrize("name", CIRCUITS)
def test_it_lacks_a_hundredth_of_a_code_at_most(name: str, wiring: str) -> None:
    """Straight between two points it lacks V''/8 · h²: h is a 64th of a kelvin."""
    sensor, spoilt = analog_specs.sensor(name), SPOILT[wiring]
    curve = curve_of(sensor, spoilt)
    low_c, high_c = sensor.range_c
    at_c = curve.first + np.arange(len(curve.millivolts)) / PER_K
    assert at_c[0] <= low_c - BELOW_K + 1
    assert at_c[-1] >= high_c + ABOVE_K - 1
    between_c = np.random.default_rng(1).uniform(at_c[0], at_c[-1], 100_000)
    lacks_mv = np.interp(between_c, at_c, curve.millivolts) - 1000 * pin_v(
        sensor, between_c, spoilt
    )
    assert np.abs(lacks_mv).max() <= CODE_MV / 100, between_c[np.abs(lacks_mv).argmax()]
