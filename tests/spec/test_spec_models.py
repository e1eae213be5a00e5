"""Attributes and defaults: what every other part of the project relies on."""

import pytest

from heatwright.spec import (
    Controller,
    Frozen,
    Heating,
    OnOff,
    Pid,
    RisingWhileOff,
    Runaway,
    SpecError,
    load_text,
)
from heatwright.spec.checks.reading import shortest_period_s
from heatwright.spec.names import LONGEST_NAME
from heatwright.spec.rules import RULES

MINIMAL = """\
heatwright: 1
controller: {name: oven, board: uno}
sensors:
  air: {kind: ds18b20, pin: A1}
outputs:
  heater: {kind: digital, pin: D3}
loops:
  air:
    sensor: air
    heater: heater
    period: 1 s
    setpoint: {initial: 20 °C, minimum: 10 °C, maximum: 70 °C}
    algorithm: {kind: on_off}
"""


def with_algorithm(text: str, output: str = "{kind: pwm, pin: D9, frequency: 1 kHz}") -> Controller:
    changed = MINIMAL.replace("{kind: on_off}", text).replace("{kind: digital, pin: D3}", output)
    return load_text(changed).controller


def test_the_least_that_is_a_spec() -> None:
    controller = load_text(MINIMAL).controller
    loop = controller.loops["air"]
    protection = loop.protection
    assert controller.identity.title is None
    assert controller.sensors["air"].resolution_bits == 12
    output = controller.outputs["heater"]
    assert (output.active, output.power_w) == ("high", None)
    assert (loop.fan, loop.period_s, loop.setpoint.stored) == (None, 1.0, False)
    assert loop.algorithm == OnOff.model_validate({"kind": "on_off"})
    assert protection.maximum_c == 85.0
    assert protection.minimum_c == -10.0
    assert protection.rise_rate_k_per_s == 5.0
    assert protection.stale_after_s == 5.0
    assert protection.heating == Heating(rise="2 K", within="120 s")  # type: ignore[arg-type]
    assert protection.runaway == Runaway.model_validate({"above": "10 K", "for": "60 s"})
    assert protection.frozen == Frozen.model_validate({"for": "10 min"})
    assert protection.rising_while_off == RisingWhileOff.model_validate(
        {"rise": "10 K", "settle": "120 s"}
    )
    assert controller.safety.watchdog_s == 2.0
    assert (controller.interfaces, controller.simulation, controller.comparison) == ((), None, ())


def test_the_default_maximum_follows_the_setpoint() -> None:
    text = MINIMAL.replace("maximum: 70 °C", "maximum: 60 °C")
    assert load_text(text).controller.loops["air"].protection.maximum_c == 75.0
    given = text + "    protection: {maximum: 66 °C}\n"
    assert load_text(given).controller.loops["air"].protection.maximum_c == 66.0


def test_protections_switched_off() -> None:
    text = "    protection: {heating: off, runaway: off, frozen: off, rising_while_off: off}\n"
    protection = load_text(MINIMAL + text).controller.loops["air"].protection
    assert protection.heating is None
    assert protection.runaway is None
    assert protection.frozen is None
    assert protection.rising_while_off is None


def test_the_defaults_of_pid() -> None:
    pid = with_algorithm("{kind: pid, kp: 5, ki: 0.1}").loops["air"].algorithm
    assert isinstance(pid, Pid)
    assert (pid.kd, pid.derivative_of, pid.derivative_filter_s) == (0.0, "measurement", 0.0)
    assert (pid.integral.minimum_percent, pid.integral.maximum_percent) == (0.0, 100.0)
    assert pid.integral.while_limited == "hold"
    assert (pid.output.minimum_percent, pid.output.maximum_percent) == (0.0, 100.0)


def test_the_defaults_of_a_window() -> None:
    output = "{kind: time_proportional, pin: D3, window: 1 s}"
    controller = with_algorithm("{kind: pid, kp: 5, ki: 0.1}", output)
    window = controller.outputs["heater"]
    assert window.kind == "time_proportional"
    assert (window.window_s, window.resolution_s) == (1.0, 0.01)
    assert (window.minimum_on_s, window.minimum_off_s) == (0.0, 0.0)


def test_the_board_runs_at_its_clock() -> None:
    assert load_text(MINIMAL).controller.board.clock_hz == 16_000_000
    slow = MINIMAL.replace("board: uno", "board: uno, clock: 8 MHz")
    controller = load_text(slow).controller
    assert controller.identity.clock_hz == 8e6
    assert controller.board.clock_hz == 8_000_000
    assert isinstance(controller.board.clock_hz, int)


@pytest.mark.parametrize("bits", [9, 10, 11, 12])
def test_the_sensors_data_sheet(bits: int) -> None:
    text = MINIMAL.replace("pin: A1", f"pin: A1, resolution: {bits} bit")
    sensor = load_text(text).controller.sensors["air"]
    assert sensor.conversion_s == {9: 0.09375, 10: 0.1875, 11: 0.375, 12: 0.75}[bits]
    assert shortest_period_s(sensor) == {9: 0.15, 10: 0.24, 11: 0.43, 12: 0.8}[bits]
    assert sensor.step_k == {9: 0.5, 10: 0.25, 11: 0.125, 12: 0.0625}[bits]
    assert [sensor.error_k(t) for t in (-55, -30, -10, 85, 100, 125)] == [2, 1, 0.5, 0.5, 1, 2]


def test_rules_keep_their_codes() -> None:
    assert {code: rule.id for code, rule in RULES.items()} == {
        1: "sensor_no_answer",
        2: "sensor_short",
        3: "sensor_crc",
        4: "sensor_stale",
        5: "sensor_reset",
        6: "over_temperature",
        7: "under_temperature",
        8: "rise_rate",
        9: "sensor_frozen",
        10: "heating_failed",
        11: "runaway_above",
        12: "runaway_below",
        13: "rising_while_off",
        14: "watchdog_reset",
        15: "brown_out",
        16: "settings_corrupt",
        17: "sensor_open",
        18: "sensor_range",
        19: "emergency_stop",
        20: "over_current",
        21: "current_while_off",
        22: "no_current",
        23: "master_lost",
        24: "program_lags",
        25: "relay_welded",
        26: "relay_open",
    }
    for code, rule in RULES.items():
        assert rule.code == code
        assert 1 <= len(rule.display) <= 12
        assert rule.display.isascii()
        assert rule.display == rule.display.upper()
        assert rule.meaning.endswith(".")
        assert rule.remedy.endswith(".")


def test_a_name_may_be_as_long_as_it_says() -> None:
    longest = "a" * LONGEST_NAME
    assert load_text(MINIMAL.replace("name: oven", f"name: {longest}"))
    with pytest.raises(SpecError, match=f"Use at most {LONGEST_NAME} characters"):
        load_text(MINIMAL.replace("name: oven", f"name: {longest}a"))


@pytest.mark.parametrize("title", ["*/ int x; /*", "a \\ b ??/ c", '"', "ü µ 漢字", "%s %n", "'"])
def test_a_title_may_be_anything_printable(title: str) -> None:
    quoted = title.replace("\\", "\\\\").replace('"', '\\"')
    text = MINIMAL.replace("name: oven", f'name: oven, title: "{quoted}"')
    assert load_text(text).controller.identity.title == title
