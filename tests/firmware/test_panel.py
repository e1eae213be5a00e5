"""What the operator sees and does: display, keys, the line to the computer."""

import numpy as np
import pytest
from test_start import SETPOINT, power_on, press

from heatwright.sim.device import AvrDevice


def started(phase_s: float = 0.0) -> AvrDevice:
    """Return the chamber after its first control step."""
    device = power_on()
    device.advance(1.5 + phase_s)
    return device


@pytest.mark.parametrize(
    ("temperature_c", "shown"),
    [
        (19.0, "T=19.0°C VT=1   "), (20.0, "T=20.0°C VT=0   "), (49.94, "T=49.9°C VT=0   "),
        (0.0, "T=0.0°C VT=1    "), (-0.03, "T=0.0°C VT=1    "), (-0.0625, "T=-0.1°C VT=1   "),
        (-9.9, "T=-9.9°C VT=1   "), (-40.0, "T=-40.0°C VT=0  "), (100.0, "T=100.0°C VT=0  "),
        (125.0, "T=125.0°C VT=0  "),
    ],
)  # fmt: skip
def test_temperature_and_heater(temperature_c: float, shown: str) -> None:
    device = power_on(felt_c=temperature_c)
    device.advance(3.5)
    assert device.shield.lcd.text[0] == shown


def test_before_the_first_reading() -> None:
    device = power_on()
    device.advance(0.9)
    assert device.shield.lcd.text == ("T=--.-°C VT=0   ", "Set temp 20°C   ")


def test_setpoints_stop_at_their_ends() -> None:
    device = started()
    for key, setpoints_c in (
        ("up", (30, 40, 50, 60, 70, 70)),
        ("down", (60, 50, 40, 30, 20, 10, 10)),
    ):
        for setpoint_c in setpoints_c:
            press(device, key)
            assert device.read(SETPOINT) == setpoint_c
            device.advance(device.time_s + 0.1)
            assert device.shield.lcd.text[1] == f"Set temp {setpoint_c}°C   "


@pytest.mark.parametrize("tolerance", [-0.1, 0.0, 0.1])
def test_cheap_resistors(tolerance: float) -> None:
    """And keys without a use change nothing."""
    device = started()
    device.shield.keypad.tolerance = tolerance
    for key, setpoint_c in (("up", 30), ("right", 30), ("left", 30), ("select", 30), ("down", 20)):
        press(device, key)
        assert device.read(SETPOINT) == setpoint_c
    assert device.read("fault.code") == 0


@pytest.mark.parametrize("bounces", [1, 2, 3, 4])
@pytest.mark.parametrize("phase_ms", range(0, 10, 3))
def test_a_bouncing_contact_is_one_press(bounces: int, phase_ms: int) -> None:
    device = started(phase_ms / 1000)
    device.shield.keypad.bounces = bounces
    for setpoint_c in (30, 40, 50):
        press(device, "up")
        assert device.read(SETPOINT) == setpoint_c


@pytest.mark.parametrize("phase_ms", range(10))
def test_a_short_press_counts_and_a_spike_does_not(phase_ms: int) -> None:
    """Two samples, 10 ms apart, have to agree: 30 ms always do, 9 ms never."""
    device = started(phase_ms / 1000)
    press(device, "up", 0.030)
    assert device.read(SETPOINT) == 30
    press(device, "up", 0.009)
    assert device.read(SETPOINT) == 30


def test_the_plotters_lines() -> None:
    """Temperature, setpoint, ten times the heater, lead: one line a step, as the step had it."""
    device = power_on(felt_c=18.0)
    for turn in range(1, 60):
        device.sense("air", 18.0 + 0.05 * turn)
        device.advance(float(turn))
    steps, lines = device.steps("air"), device.plotter.lines
    assert device.plotter.garbage == 0
    assert len(lines) >= len(steps) - 1
    for step, line in zip(steps, lines, strict=False):
        lead_k = np.float32(12) * step["algorithm.rate_k_per_s"]
        wanted = (step["temperature_c"], step["setpoint_c"], step["duty_percent"] / 10, lead_k)
        assert line.values == pytest.approx(wanted, abs=0.0051)
        assert 0 < line.time_s - step["time_s"] < 0.2
