"""What drawing controllers has brought to light, each as the smallest spec that shows it."""

import pytest
from rig.avr import whole
from rig.specs import files_of, spec_of

from heatwright.spec import SpecError

TEXT = """
heatwright: 1
controller: {{name: found, board: uno}}
sensors: {{air: {{kind: ds18b20, pin: A1}}}}
outputs: {{heater: {{{output}, pin: D2, power: 100 W}}}}
loops:
  air:
    sensor: air
    heater: heater
    period: {period}
    algorithm: {{kind: on_off}}
    setpoint: {{initial: 20 °C, minimum: 10.3 °C, maximum: 70.2 °C}}
    protection: {{{protection}}}
interfaces: [{{kind: lcd_keypad, loop: air, step: 59.9 K}}]
simulation:
  ambient: 20 °C
  plant:
    kind: thermal_network
    nodes: {{air: 900 J/K}}
    links: [{{between: [air, ambient], resistance: 1 K/W}}]
    heat: {{heater: air}}
    sense: {{air: {{node: air}}}}
  scenario: [{{for: 1 min}}]
"""
DIGITAL, WINDOW = "kind: digital", "kind: time_proportional, window: 40 s"
NO_RULES = "heating: off, runaway: off, frozen: off, rising_while_off: off"


def text(period: str = "1 s", protection: str = "stale_after: 5 s", output: str = DIGITAL) -> str:
    return TEXT.format(period=period, protection=protection, output=output)


def test_as_many_periods_as_can_be_counted_are_taken_as_the_file_says_them() -> None:
    """0.83 · 255 is a little less than 211.65 in binary, and 70.2 − 10.3 than 59.9."""
    protection = spec_of(text("0.83 s", "stale_after: 211.65 s")).controller.loops["air"].protection
    assert protection.stale_after_s == 211.65
    assert "STALE_STEPS 255u" in files_of(text("0.83 s", "stale_after: 211.65 s"))["src/config.h"]


def test_permits_longer_than_their_counters_compile() -> None:
    long_ago = text("10 min", f"stale_after: 20 min, {NO_RULES}").partition("simulation:")[0]
    config = files_of(long_ago)["src/config.h"]
    assert "LOOP_AIR_PERMIT_TICKS 65535u" in config
    assert "LOOP_AIR_SENSOR_PERMIT_TICKS 65535u" in config
    whole(long_ago)


def test_a_heater_may_wait_for_its_window_before_it_heats() -> None:
    heating = "heating: {rise: 0.1 K, within: 30 s}"
    spec_of(text(protection=heating))
    with pytest.raises(SpecError, match=r"heating\.within: this plant, healthy"):
        spec_of(text(protection=heating, output=WINDOW))


def test_two_converters_with_registers_share_no_name() -> None:
    one = text().partition("simulation:")[0].replace("uno", "mega2560")
    wires = "kind: max31856, chip_select: D{}, clock: D{}, data_in: D{}, data_out: D{}"
    tips = ", ".join(
        f"{name}: {{{wires.format(*range(first, first + 4))}}}"
        for name, first in (("air", 22), ("wall", 30))
    )
    both = one.replace("{air: {kind: ds18b20, pin: A1}}", f"{{{tips}}}").replace(
        "pin: D2", "pin: D3"
    )
    loop = both[both.index("  air:\n    sensor") : both.index("interfaces:")]
    wall = loop.replace("air:", "wall:").replace("sensor: air", "sensor: wall")
    wall = wall.replace("heater: heater", "heater: other")
    both = both.replace(loop, loop + wall)
    whole(both.replace("{heater: {", "{other: {kind: digital, pin: D40, power: 9 W}, heater: {"))
