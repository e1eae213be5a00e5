"""What compiles whatever a spec says: any name, another crystal; and what must not."""

import pytest
from jinja2 import UndefinedError
from rig.avr import whole
from rig.specs import changed, controller_of, files_of

from heatwright.generator import render
from heatwright.generator.plan import File, Plan
from heatwright.spec.names import LONGEST_NAME

PLAIN = changed("chamber").partition("simulation:")[0]


def test_an_undefined_name_is_an_error() -> None:
    file = File("src/clock.c", "src/clock.c.j2", {"tick_ms": 10})
    with pytest.raises(UndefinedError, match="'tick' is undefined"):
        render(Plan("name", "banner", (file,)))


@pytest.mark.parametrize("name", ["ticks", "fault", "i_2", "w" * LONGEST_NAME])
def test_a_name_may_be_any_word_of_the_firmware(name: str) -> None:
    """One name for sensor, output and loop at once, and one the firmware uses itself."""
    whole(f"""
heatwright: 1
controller: {{name: {name}, board: mega2560}}
sensors: {{{name}: {{kind: ds18b20, pin: A1}}}}
outputs: {{{name}: {{kind: digital, pin: D22, power: 100 W}}}}
loops:
  {name}:
    sensor: {name}
    heater: {name}
    period: 1 s
    setpoint: {{initial: 20 °C, minimum: 10 °C, maximum: 70 °C, stored: true}}
    algorithm: {{kind: on_off, lead: 2 s}}
interfaces: [{{kind: lcd_keypad, loop: {name}}}, {{kind: serial_plotter, loop: {name}}}]
""")


@pytest.mark.parametrize("clock_mhz", [8, 14.7456, 20])
def test_another_crystal(clock_mhz: float) -> None:
    """PlatformIO is told of it, and no other clock compiles: every time would be wrong."""
    text = changed("chamber", ("board: uno", f"board: uno\n  clock: {clock_mhz} MHz"))
    text = text.partition("interfaces:")[0]
    clock_hz = controller_of(text).board.clock_hz
    assert clock_hz == round(clock_mhz * 1e6)
    assert f"\nboard_build.f_cpu = {clock_hz}L\n" in files_of(text)["platformio.ini"]
    whole(text)
    with pytest.raises(AssertionError, match=f"generated for a {clock_mhz:g} MHz clock"):
        whole(text, "-UF_CPU", "-DF_CPU=16000000UL")
    with pytest.raises(AssertionError, match="choose that board"):
        whole(text, "-U__AVR_ATmega328P__")


def test_the_boards_own_clock_is_left_to_platformio() -> None:
    assert "f_cpu" not in files_of("chamber")["platformio.ini"]


def test_as_many_periods_as_can_be_counted_are_taken_as_the_file_says_them() -> None:
    """0.83 · 255 is a little less than 211.65 in binary, and 70.2 − 10.3 than 59.9."""
    text = changed(
        PLAIN, ("period: 1 s", "period: 0.83 s"), ("stale_after: 5 s", "stale_after: 211.65 s"),
        ("minimum: 10 °C, maximum: 70 °C", "minimum: 10.3 °C, maximum: 70.2 °C"),
        ("step: 10 K", "step: 59.9 K"),
    )  # fmt: skip
    assert controller_of(text).loops["air"].protection.stale_after_s == 211.65
    assert "STALE_STEPS 255u" in files_of(text)["src/config.h"]


def test_two_converters_with_registers_share_no_name() -> None:
    wires = "chip_select: D{0}0, clock: D{0}1, data_in: D{0}2, data_out: D{0}3"
    air, wall = (f"{{kind: max31856, {wires.format(place)}}}" for place in (3, 4))
    settings = "period: 1 s, setpoint: {initial: 20 °C, minimum: 10 °C, maximum: 70 °C}"
    loop = f"{{sensor: wall, heater: other, {settings}, algorithm: {{kind: on_off}}}}"
    whole(changed(
        PLAIN, ("{kind: ds18b20, pin: A1, resolution: 12 bit}", f"{air}\n  wall: {wall}"),
        ("\nsafety:", f"  wall: {loop}\nsafety:"), ("board: uno", "board: mega2560"),
        ("outputs:", "outputs:\n  other: {kind: digital, pin: D22, power: 9 W}"),
    ))  # fmt: skip
