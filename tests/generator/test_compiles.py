"""What compiles whatever a spec says: any name, another crystal; and what must not."""

import pytest
from jinja2 import UndefinedError
from rig.avr import whole
from rig.specs import changed, controller_of, files_of

from heatwright.generator import render
from heatwright.generator.plan import File, Plan
from heatwright.spec.names import LONGEST_NAME


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
