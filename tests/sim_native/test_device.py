"""The binary as a device on the bench."""

from pathlib import Path

import numpy as np
import pytest
from rig.avr import compiled, shared

from heatwright.sim.device import AvrDevice, StaleBinary
from heatwright.sim.elf import Elf, ElfError
from heatwright.sim.vcd import VcdRecorder
from heatwright.spec import Controller, digest


@pytest.fixture(scope="module")
def program(chamber: Controller) -> Elf:
    return shared("chamber_stub.c", f"-DDIGEST=0x{digest(chamber)}")


@pytest.fixture
def device(chamber: Controller, program: Elf) -> AvrDevice:
    return AvrDevice(chamber, program)


def test_the_binary_must_be_of_this_spec(chamber: Controller) -> None:
    message = f"another spec .digest 00000000, not {digest(chamber)}.: generate and build it again"
    with pytest.raises(StaleBinary, match=message):
        AvrDevice(chamber, shared("chamber_stub.c"))


def test_a_binary_without_its_state(chamber: Controller) -> None:
    source = f"const uint32_t spec_digest PROGMEM __attribute__((used)) = 0x{digest(chamber)};"
    with pytest.raises(ElfError, match="no variable loop_air"):
        AvrDevice(chamber, compiled(f"{source} volatile char x; int main(void) {{ x = 1; }}"))


def test_steps_are_rows(device: AvrDevice) -> None:
    device.advance(5.5)
    steps = device.steps("air")
    assert steps.dtype.names == (
        "time_s",
        "steps",
        "reading_status",
        "reading_raw",
        "temperature_c",
        "guard.heating_steps",
        "fault.code",
        "fault.temperature_c",
        "fault.time_s",
    )
    assert steps["steps"].tolist() == [1, 2, 3, 4, 5]
    assert steps["temperature_c"].tolist() == [20.5, 21, 21.5, 22, 22.5]
    assert np.allclose(steps["time_s"], [1, 2, 3, 4, 5], atol=2e-3)
    device.advance(6.5)
    assert len(device.steps("air")) == 6
    with pytest.raises(KeyError):
        device.steps("nozzle")


def test_outputs_over_any_stretch(device: AvrDevice) -> None:
    device.advance(0.5)
    assert device.on_fraction("heater") == 0
    device.advance(8.5)
    assert device.on_fraction("heater") == pytest.approx(6 / 8, abs=0.01)
    assert device.on_fraction("fan") == pytest.approx(1, abs=1e-4)


def test_keys_reach_the_program(device: AvrDevice) -> None:
    device.advance(1)
    assert device.read("guard_air.heating_steps") == 1023
    device.press("up")
    device.advance(1.1)
    assert device.read("guard_air.heating_steps") == 131
    device.press(None)
    device.advance(1.2)
    assert device.read("guard_air.heating_steps") == 1023


def test_a_bouncing_key_is_let_bounce(device: AvrDevice) -> None:
    device.shield.keypad.bounces = 3
    device.advance(1)
    device.press("up")
    device.advance(1.1)
    assert device.read("guard_air.heating_steps") == 131


def test_sensors_feel_the_temperature(device: AvrDevice) -> None:
    device.sense("air", 55.5)
    assert device.sensors["air"].temperature_c == 55.5


def test_the_line_is_listened_to(device: AvrDevice) -> None:
    device.advance(9)
    assert [line.values for line in device.plotter.lines] == [(1.0,), (1.0,)][
        : len(device.plotter.lines)
    ]
    assert device.plotter.lines


def test_power_cycles_keep_the_eeprom_and_the_clock(device: AvrDevice) -> None:
    device.advance(8.5)
    assert device.read("fault.time_s") == 0xFF
    device.power_cycle()
    assert device.time_s == pytest.approx(8.5, abs=1e-3)
    assert device.on_fraction("heater") == 0
    device.advance(11)
    assert device.read("fault.time_s") == 42
    assert device.read("fault.code") == 1  # power-on
    steps = device.steps("air")
    assert steps["steps"].tolist() == [1, 2, 3, 4, 5, 6, 7, 8, 1, 2]
    assert np.all(np.diff(steps["time_s"]) > 0.4)


def test_power_cut_while_a_byte_is_written(device: AvrDevice) -> None:
    device.advance(6.999)
    while device.avr.eeprom.writing is None:
        device.advance(device.time_s + 0.0005)
    device.power_cycle(undefined=0x5A)
    device.advance(device.time_s + 0.1)
    assert device.read("fault.time_s") == 0x5A


def test_recorders_get_everything(device: AvrDevice, tmp_path: Path) -> None:
    with VcdRecorder(tmp_path / "x.vcd", {"heater": "PD3"}, device.avr.clock_hz) as recorder:
        device.record(recorder)
        device.advance(4.5)
        device.feed()
    text = (tmp_path / "x.vcd").read_text()
    assert text.count("\n1!") == 1
    assert "heater" in text


def test_a_spec_without_a_shield(chamber: Controller) -> None:
    bare = chamber.model_copy(update={"interfaces": ()})
    program = shared("chamber_stub.c", f"-DDIGEST=0x{digest(bare)}")
    with pytest.raises(LookupError, match="chamber has no LcdKeypad"):
        AvrDevice(bare, program).press("up")


def test_two_devices_are_equal(chamber: Controller, program: Elf) -> None:
    first, second = AvrDevice(chamber, program), AvrDevice(chamber, program)
    first.advance(10)
    for time_s in np.linspace(0.01, 10, 77):
        second.advance(float(time_s))
    assert first.steps("air").tobytes() == second.steps("air").tobytes()
