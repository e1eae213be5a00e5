"""What the operator sees and does: display, keys, the line to the computer."""

from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np
import pytest
import test_start
from rig.avr import whole
from rig.specs import changed, controller_of
from suite import SEED, amount
from test_start import CHAMBER, SETPOINT, power_on, press

from heatwright.sim.bench import ReferenceDevice
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
    for key, setpoints_c in (("up", (30, 40, 50, 60, 70, 70)), ("down", (60, 50, 40, 30, 20, 10))):
        for setpoint_c in setpoints_c:
            press(device, key)
            assert device.read(SETPOINT) == setpoint_c
            device.advance(device.time_s + 0.1)
            assert device.shield.lcd.text[1] == f"Set temp {setpoint_c}°C   "


@pytest.mark.parametrize(("key", "left_at"), [("down", "10"), ("left", "20")])
def test_off_at_once_and_on_again(key: str, left_at: str) -> None:
    """DOWN from the lowest setpoint, LEFT from any; the display says what UP will do."""
    device = power_on(felt_c=5.0)
    device.advance(1.5)
    if key == "down":
        press(device, key)
    assert device.outputs["heater"].on
    press(device, key, 0.04)
    assert not device.outputs["heater"].on
    for again in ("down", "left", "right", "select", None, "up"):
        press(device, again)
        device.advance(device.time_s + 0.1)
        off = again != "up"
        assert device.shield.lcd.text[1][:11] == f"{'OFF, UP: ' if off else 'Set temp '}{left_at}"
        device.advance(device.time_s + 2.0)
        assert device.outputs["heater"].on != off


@pytest.mark.parametrize("tolerance", [-0.1, 0.0, 0.1])
def test_cheap_resistors(tolerance: float) -> None:
    """And a key without a use changes nothing."""
    device = started()
    device.shield.keypad.tolerance = tolerance
    for key, setpoint_c, on in (
        ("up", 30, 1), ("right", 30, 1), ("select", 30, 1), ("left", 30, 0), ("up", 30, 1),
        ("down", 20, 1),
    ):  # fmt: skip
        press(device, key)
        device.advance(device.time_s + 1.0)
        assert (device.read(SETPOINT), device.read("loop_air.enabled")) == (setpoint_c, on)
    assert device.read("fault.code") == 0


KEYS = ("up", "down", "left", "right", "select")
PLOTTER = "kind: serial_plotter, loop: air, baud: 9600"
OTHERS = {
    "off at first": changed("chamber", ("starts: enabled  ", "starts: disabled ")),
    "a host": changed("chamber", (PLOTTER, "kind: gcode, loops: {T0: air}")),
    "a master": changed("chamber", (PLOTTER, "kind: modbus_rtu")),
}
"""Who else there is, or how it starts, and the specification."""


def chosen(key: str, draw: Random, name: str) -> Callable[[Any], object]:
    """Return what is done to a device: mostly a press, else a fault or an order of others."""
    turn = draw.random()
    if turn < 0.05:
        return lambda device: device.sense("air", 90.0)
    if turn < 0.3 and name == "a host":
        line = draw.choice(("M104 S0", "M104 S55", "M104 S10"))
        return lambda device: device.send(line)
    if turn < 0.3 and name == "a master":
        on = draw.random() < 0.7
        return lambda device: device.write("air.enabled", on)
    return lambda device: device.press(key)


@pytest.mark.parametrize("name", ["alone", *OTHERS])
def test_any_keys_do_what_the_model_does(name: str) -> None:
    """Step by step to the last bit, and the second line says it."""
    draw = Random(f"panel {SEED} {name}")  # noqa: S311 - no secret
    controller = controller_of(OTHERS[name]) if name in OTHERS else CHAMBER
    board = AvrDevice(controller, whole(OTHERS[name]) if name in OTHERS else test_start.program())
    model = ReferenceDevice(controller)
    shown = []
    for second in range(amount("panel_keys")):
        act = chosen(draw.choice(KEYS), draw, name)
        for device in (board, model):
            device.advance(second + 0.15)
        shown.append(board.shield.lcd.text[1].rstrip())
        for device in (board, model):
            device.sense("air", 19.0)
            act(device)
            device.advance(second + 0.4)
            device.press(None)
    ours, its = board.steps("air"), model.steps("air")
    for member in set(its.dtype.names or ()) - {"time_s"}:
        assert ours[member].tolist() == its[member].tolist(), member
    for text, row in zip(shown[1:], its, strict=True):
        assert text == second_line(row, name) or row["fault.code"]


def second_line(row: Any, name: str) -> str:
    """Return what the display says after a step."""
    on = row["setpoint_c"] if name == "a host" else row["enabled"]
    if not on and name == "a host":
        return "OFF"
    return f"{'Set temp' if on else 'OFF, UP:'} {row['setpoint_c']:.0f}°C"


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
