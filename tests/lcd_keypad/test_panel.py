"""What the operator sees and does: display, keys, the line to the computer."""

import re
from collections.abc import Callable
from operator import methodcaller
from random import Random
from typing import Any

import numpy as np
import pytest
import test_start
from rig.firmware import changed, controller_of, device_of, whole
from suite import SEED, amount
from test_start import CHAMBER, ROOM_C, SETPOINT, power_on, press, put

from heatwright.sim.bench import ReferenceDevice
from heatwright.sim.device import AvrDevice
from heatwright.spec import facts_of
from heatwright.spec.rules import RULES


def started(phase_s: float = 0.0) -> AvrDevice:
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


@pytest.mark.parametrize("code", [200, 255])
def test_a_code_of_no_rule_is_told_as_one(code: int) -> None:
    """Damaged memory may hold any."""
    device = started()
    put(device, "fault.code", code)
    put(device, "fault_complement", 255 - code)
    device.advance(3.5)
    assert device.shield.lcd.text[1] == "E?? NO SUCH CODE"


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


def test_somebody_at_the_keys_stands_in_for_the_host() -> None:
    """Who heats by keys beside a host that is not there has its time from each press on."""
    device = device_of(OTHERS["a host"], 75.0)
    device.advance(1.5)
    press(device, "left")
    device.advance(900.0)
    for seconds in (590.0, 590.0, 602.0):
        assert device.read("fault.code") == 0
        press(device, "up")
        device.advance(device.time_s + seconds)
    assert RULES[int(device.read("fault.code"))].id == "master_lost"
    assert device.shield.lcd.text[1].rstrip() == "E23 MASTER LOST"
    press(device, "select")
    device.advance(device.time_s + 900.0)
    assert device.read("fault.code") == 0  # of a loop that is off nothing need be heard


TIMED = ("up", "right", "up")  # On, for the shortest time
KEYS = ("up", "down", "left", "right", "select")
PLOTTER = "kind: serial_plotter, loop: air, baud: 9600"
STARTS = ("starts: enabled  ", "starts: disabled ")


def time_of(keys: str) -> tuple[str, str]:
    return "step: 10 K}", f"step: 10 K, countdown: {{{keys}}}}}"


HYSTERESIS = "hysteresis: {minimum: 0 K, maximum: 0.6 K, step: 0.2 K}"
LEAD = "lead: {minimum: 2.5 s, maximum: 20 s, step: 2.5 s}"


def adjusted(numbers: str, others: str = "") -> tuple[str, str]:
    return "step: 10 K}", f"step: 10 K, adjust: {{{numbers}}}{others}}}"


HOST, MASTER = (PLOTTER, "kind: gcode, loops: {T0: air}"), (PLOTTER, "kind: modbus_rtu")
OTHERS = {
    "off at first": changed("chamber", STARTS),
    "a host": changed("chamber", HOST, ("stale_after: 5 s", "stale_after: 5 s\n      effort: off")),
    "a master": changed("chamber", MASTER),
    "a time": changed("chamber", STARTS, time_of("longest: 3 min, step: 1 min")),
    "numbers": changed("chamber", STARTS, adjusted(f"{HYSTERESIS}, {LEAD}")),
    "a host and a number": changed("chamber", HOST, adjusted(LEAD)),
    "a time and a number": changed(
        "chamber", STARTS, adjusted(HYSTERESIS, ", countdown: {longest: 3 min, step: 1 min}")
    ),
    "numbers of a PID": changed("oven", STARTS),
    "a master's time": changed(
        "chamber", STARTS, time_of("longest: 4 min, step: 2 min, counts: at once"), MASTER,
        ("period: 1 s", "period: 2 s"),
    ),
}  # fmt: skip
"""Who else there is, or how it starts, and the specification."""


def chosen(key: str, draw: Random, name: str) -> Callable[[Any], object]:
    """Return what is done to a device: mostly a press, else a fault or an order of others."""
    turn = draw.random()
    if turn < (0.005 if "time" in name else 0.05):
        return lambda device: device.sense("air", 90.0)
    if turn < 0.3 and "a host" in name:
        line = draw.choice(("M104 S0", "M104 S55", "M104 S10"))
        return lambda device: device.send(line)
    if turn < 0.3 and name == "a master":
        on = draw.random() < 0.7
        return lambda device: device.write("air.enabled", on)
    if turn < 0.93 and "time" in name:
        return lambda device: device.press(None)  # time goes by
    return lambda device: device.press(key)


@pytest.mark.parametrize("name", ["alone", *OTHERS])
def test_any_keys_do_what_the_model_does(name: str) -> None:
    """Step by step to the last bit, and the second line says it."""
    draw = Random(f"panel {SEED} {name}")  # noqa: S311 - no secret
    controller = controller_of(OTHERS[name]) if name in OTHERS else CHAMBER
    board = AvrDevice(controller, whole(OTHERS[name]) if name in OTHERS else test_start.program())
    model = ReferenceDevice(controller)
    shown, told = [], []
    numbers = facts_of(controller, "air").keyed_numbers
    first = [*TIMED] if "time" in name else ["up"] * bool(numbers)
    first += ["right", "up", "up"] * len(numbers) + ["right"]
    for second in range(amount("panel_keys") * (4 if "time" in name else 1)):
        act = chosen(draw.choice(KEYS), draw, name)
        if second < len(first):
            act = methodcaller("press", first[second])
        for device in (board, model):
            device.advance(second + 0.15)
        shown.append([re.sub("VT=.", "VT", line.rstrip()) for line in board.shield.lcd.text])
        told.append(lines_of(model, board, name))
        for device in (board, model):
            device.sense("air", 19.0)
            act(device)
            device.advance(second + 0.4)
            device.press(None)
    ours, its = board.steps("air"), model.steps("air")
    for member in set(its.dtype.names or ()) - {"time_s"}:
        assert ours[member].tolist() == its[member].tolist(), member
    for number in numbers:
        assert len(np.unique(its[f"algorithm.{number.kind.field}"])) > 2
    period = 2 if "period: 2 s" in OTHERS.get(name, "") else 1
    for lines, wanted, row in zip(shown[period::period], told[period::period], its, strict=True):
        if not row["fault.code"]:
            assert lines == wanted


def lines_of(model: ReferenceDevice, board: AvrDevice, name: str) -> list[str]:
    """Return what the display says of a model at the board's setpoint."""
    setpoint, doing = f"{board.read(SETPOINT):.0f}°C", " VT"
    second = f"Set temp {setpoint}"
    if model.is_off("air"):
        second = "OFF" if "a host" in name else f"OFF, UP: {setpoint}"
    if countdown := model.countdown:
        minutes, counts = countdown.minutes_left, countdown.left is not None
        clock = f"{minutes // 60}:{minutes % 60:02}"
        doing = f"{'-' if counts else ' '}{clock}" if minutes else doing
        doing = " OFF" if model.is_off("air") else doing
        second = second.replace("OFF,", "Done") if countdown.ended else second
        if model.page == "time":
            second = f"Off {'in' if counts else 'after'} {clock}" if minutes else "No time is set"
    for number in facts_of(controller_of(OTHERS.get(name, "chamber")), "air").keyed_numbers:
        kind = number.kind
        if model.page == kind.key:
            value = f"{model.numbers[kind.field]:.{number.decimals}f}"
            second = f"{kind.title}{value}{kind.shown_unit}"
    return [f"T=19.0°C{doing}", second]


OF_NUMBER = "settings.air_hysteresis_k", "algorithm_air.hysteresis_k"


def numbered(eeprom: bytes = b"") -> AvrDevice:
    device = device_of(OTHERS["numbers"], ROOM_C)
    device.avr.eeprom.contents = eeprom
    device.advance(1.5)
    for key in ("up", "right"):
        press(device, key)
    return device


def test_a_number_is_kept_when_it_has_rested() -> None:
    """10 s after the last press, and not before."""
    device = numbered()
    assert device.shield.lcd.text[1] == "Hysteresis 0.0K "
    for shown in ("0.2", "0.4", "0.6", "0.6"):
        press(device, "up")
        device.advance(device.time_s + 0.1)
        assert device.shield.lcd.text[1] == f"Hysteresis {shown}K "
    press(device, "down")
    for waits_s, kept in ((9.5, "0.0"), (2.0, "0.4")):
        device.advance(device.time_s + waits_s)
        again = numbered(device.avr.eeprom.contents)
        assert again.shield.lcd.text[1] == f"Hysteresis {kept}K "


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, -1e-3, 0.601, 1e30])
def test_a_number_that_no_key_sets_is_the_specs(value: float) -> None:
    """Damaged in RAM, from the next step on; while the loop is off, as soon as it is shown."""
    bits = int(np.float32(value).view(np.uint32))
    device = numbered()
    press(device, "up")
    device.advance(device.time_s + 2.0)
    assert device.read(OF_NUMBER[1]) == np.float32(0.2)
    put(device, OF_NUMBER[0], bits)
    device.advance(device.time_s + 2.0)
    assert [device.read(each) for each in OF_NUMBER] == [0, 0]
    assert device.shield.lcd.text[1] == "Hysteresis 0.0K "
    for key, wanted in (("up", 0.2), ("down", 0.0)):
        press(device, "left")
        press(device, "right")
        put(device, OF_NUMBER[0], bits)
        press(device, key)
        assert device.read(OF_NUMBER[0]) == np.float32(wanted)
    put(device, OF_NUMBER[0], bits)
    device.advance(device.time_s + 2.0)
    assert device.shield.lcd.text[1] == "Hysteresis 0.0K "
    assert device.read("loop_air.enabled") == 0


LONG = changed(
    "chamber", STARTS, time_of("longest: 30 h, step: 1 min"), ("within: 120 s", "within: 1 h")
)
SLOW = changed(
    "chamber", STARTS, time_of("longest: 6 min, step: 2 min, counts: at once"),
    MASTER, ("period: 1 s", "period: 70 s"),
    ("above: 10 K, for: 60 s}", "above: 15 K, for: 70 s}"),
    ("stale_after: 5 s", "stale_after: 140 s"), ("within: 120 s", "within: 1 h"),
)  # fmt: skip


def timed() -> AvrDevice:
    device = device_of(LONG, ROOM_C)
    device.advance(1.5)
    for key in ("up", "right", "up", "up", "up"):
        press(device, key)
    device.advance(5.5)
    assert device.shield.lcd.text == ("T=19.0°C-0:03   ", "Off in 0:03     ")
    return device


@pytest.mark.parametrize("member", ["minutes", "counting", "left", "check"])
def test_a_bit_that_flips_ends_the_time_at_once(member: str) -> None:
    """At the next step, or at a key before it; then it is as after a reset."""
    device = timed()
    for bit in range(8 * device.variables[f"countdown.{member}"].size):
        began_s = device.time_s
        flipped = int(device.read(f"countdown.{member}")) ^ 1 << bit
        put(device, f"countdown.{member}", flipped)
        left = 3
        if bit % 2:
            press(device, "up")
            left = 2
        device.advance(began_s + 0.6)
        assert not device.outputs["heater"].on
        told = "Off after 0:01  " if bit % 2 else "No time is set  "
        assert device.shield.lcd.text == ("T=19.0°C OFF    ", told)
        press(device, "right")
        assert device.shield.lcd.text[1] == "OFF, UP: 20°C   "
        for key in ("up", "right", *["up"] * left):
            press(device, key)
        device.advance(began_s + 3.0)
        assert device.shield.lcd.text == ("T=19.0°C-0:03   ", "Off in 0:03     ")


def test_a_time_below_a_step_is_over_with_it() -> None:
    """Of 4 min two whole periods are left, which is shown as 3 min; two less are none. A master
    that goes on saying "on" is not obeyed before it has said "off"."""
    controller = controller_of(SLOW)
    board = AvrDevice(controller, whole(SLOW))
    for device in (board, ReferenceDevice(controller)):
        device.sense("air", ROOM_C)
        for second, key in {1: "up", 2: "right", 3: "up", 4: "up", 150: "down"}.items():
            device.advance(second)
            device.press(key)
            device.advance(second + 0.2)
            device.press(None)
        device.advance(290.0)
        assert device.steps("air")["enabled"].tolist() == [1, 1, 1, 0]
    for second, orders in ((300.0, (True,)), (360.0, (False, True))):
        board.advance(second)
        for on in orders:
            board.master.ask(board.master.request("air.enabled", value=on).pdu)
    board.advance(430.0)
    assert board.steps("air")["enabled"].tolist()[4:] == [0, 1]


def test_a_key_held_down_changes_the_time_and_no_setpoint() -> None:
    """Ten steps a second after half a second, and ten times as much after twenty of them."""
    device = timed()
    press(device, "up", 0.1 + 0.4 + 1.0)
    device.advance(device.time_s + 0.1)
    assert device.shield.lcd.text[1].split() == ["Off", "in", f"0:{3 + 1 + 10:02}"]
    press(device, "up", 24.0)
    step_s = np.ceil(device.time_s) + 0.2
    for steps, left in ((0, "30:00"), (58, "30:00"), (59, "29:59")):
        device.advance(step_s + steps)
        assert device.shield.lcd.text[1].split() == ["Off", "in", left]
    press(device, "down", 30.0)
    device.advance(device.time_s + 0.1)
    assert device.shield.lcd.text[1].split() == ["Off", "in", "0:09"]
    press(device, "right")
    for key, setpoint_c in (("up", 30), ("down", 20), ("up", 30)):
        press(device, key, 3.0)
        assert device.read(SETPOINT) == setpoint_c


def test_a_time_waits_for_the_setpoint() -> None:
    """A loop that was off waits, too, with what was set before."""
    device = timed()
    for key in ("right", "up", "left"):
        press(device, key)
    device.advance(device.time_s + 0.1)
    assert device.shield.lcd.text == ("T=19.0°C OFF    ", "OFF, UP: 30°C   ")
    press(device, "up")
    for felt_c, sign in ((19.0, " "), (23.0, " "), (27.0, " "), (29.5, "-")):
        device.sense("air", felt_c)
        device.advance(device.time_s + 2.5)
        assert device.shield.lcd.text == (f"T={felt_c}°C{sign}0:01   ", "Set temp 30°C   ")


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


@pytest.mark.parametrize(("decimals", "line_end"), [(2, "LF"), (1, "CR LF"), (0, "LF")])
def test_the_plotters_lines(decimals: int, line_end: str) -> None:
    """Temperature, setpoint, ten times the heater, lead: one line a step, as the step had it."""
    device = power_on(felt_c=18.0)
    if decimals != 2:  # else it is the chamber, which an arena may have broken
        form = f"{PLOTTER}, line_end: {line_end}, decimals: {decimals}"
        device = device_of(changed("chamber", (PLOTTER, form)), 18.0)
    for turn in range(1, 60):
        device.sense("air", 18.0 + 0.05 * turn)
        device.advance(float(turn))
    steps, lines = device.steps("air"), device.plotter.lines
    assert device.plotter.garbage == 0
    assert len(lines) >= len(steps) - 1
    assert device.plotter.ended == len(lines) - 1
    for step, line in zip(steps, lines, strict=False):
        lead_k = np.float32(12) * step["algorithm.rate_k_per_s"]
        wanted = (step["temperature_c"], step["setpoint_c"], step["duty_percent"] / 10, lead_k)
        assert line.values == pytest.approx(wanted, abs=0.501 * 10**-decimals)
        assert 0 < line.time_s - step["time_s"] < 0.2


AUTHORS_PID = changed(
    changed("oven").partition("# The published gains")[0],
    ("maximum: 70 °C", "maximum: 60 °C"),  # what 60 % hold
    ("kp: 32 ", "kp: 50 "), ("ki: 0.19 ", "ki: 0.6 "), ("kd: 400 ", "kd: 800 "),
    ("derivative_filter: 3 s", "derivative_of: error\n      derivative_filter: 4 s\n"
     "      integral: {minimum: 0 %, maximum: 60 %, while_limited: run}"),
    ("kind: time_proportional, pin: D3, window: 1 s", "kind: pwm, pin: D3, frequency: 490 Hz"),
    ("kp: {minimum: 20, maximum: 45, step: 1}", "kp: {minimum: 20, maximum: 60, step: 1}"),
    ("ki: {minimum: 0.1, maximum: 0.3, step: 0.01}", "ki: {minimum: 0.1, maximum: 0.6, step: 0.1}"),
    ("kd: {minimum: 200, maximum: 600, step: 20}", "kd: {minimum: 200, maximum: 800, step: 20}"),
)  # fmt: skip
"""The oven under its comparison's row `PID`, and its author's line."""


def test_the_plotters_line_of_a_pid() -> None:
    """Temperature, setpoint, P, I, D, a tenth of their sum and of the duty, ended by CR LF."""
    controller = controller_of(AUTHORS_PID)
    row = next(row for row in controller_of("oven").comparison if row.name == "PID")
    assert controller.loops["air"].algorithm == row.algorithm
    device = device_of(AUTHORS_PID)
    for turn in range(60):  # up to the setpoint, beyond it, and back
        device.sense("air", 50.0 + 3.0 * np.sin(turn / 8 - np.pi / 3))
        device.advance(turn + 1.0)
    steps, lines = device.steps("air"), device.plotter.lines
    assert device.plotter.garbage == 0
    assert len(lines) >= len(steps) - 1
    assert device.plotter.ended == len(lines) - 1
    limited = set()
    for step, line in zip(steps, lines, strict=False):
        own = {name: step[f"algorithm.{name}"] for name in ("proportional", "integral")}
        terms = (*own.values(), step["algorithm.kd"] * step["algorithm.derivative"])
        shown = (sum(terms) / 10, step["duty_percent"] / 10)
        wanted = (step["temperature_c"], step["setpoint_c"], *terms, *shown)
        assert line.values == pytest.approx(wanted, abs=0.501 * 10**-2)
        limited.add(bool(abs(shown[0] - shown[1]) > 1))
    assert limited == {True, False}, "sum and duty are told apart, and are one"
