"""The binary as a device on the bench."""

from pathlib import Path

import numpy as np
import pytest
from rig.avr import compiled, whole

from heatwright.sim.device import AvrDevice, StaleBinary
from heatwright.sim.elf import ElfError
from heatwright.sim.vcd import VcdRecorder
from heatwright.spec import Controller, digest


@pytest.fixture
def device(chamber: Controller) -> AvrDevice:
    return AvrDevice(chamber, whole("chamber"))


def test_the_binary_must_be_of_this_spec(chamber: Controller, oven: Controller) -> None:
    message = rf"another spec .digest {digest(chamber)}, not {digest(oven)}.: generate and build it"
    with pytest.raises(StaleBinary, match=message):
        AvrDevice(oven, whole("chamber"))


def test_a_binary_without_its_state(chamber: Controller) -> None:
    source = f"const uint32_t spec_digest PROGMEM __attribute__((used)) = 0x{digest(chamber)};"
    with pytest.raises(ElfError, match="no variable loop_air"):
        AvrDevice(chamber, compiled(f"{source} volatile char x; int main(void) {{ x = 1; }}"))


def test_rows_outlive_a_power_cycle_as_the_eeprom_and_the_clock_do(
    device: AvrDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    device.sense("air", 25.5)
    device.advance(3.5)
    left = lambda undefined: bytes([undefined]) * 1024  # noqa: E731
    monkeypatch.setattr(device.avr.eeprom, "after_power_cut", left)
    device.power_cycle(undefined=0x5A)
    assert device.avr.eeprom.contents == left(0x5A)
    assert device.time_s == pytest.approx(3.5, abs=1e-3)
    assert device.on_fraction("heater") == 0
    device.advance(6.0)
    steps = device.steps("air")
    assert steps.dtype.names is not None
    assert {"time_s", "steps", "reading_raw", "guard.heating_steps"} <= set(steps.dtype.names)
    assert steps["steps"].tolist() == [1, 2, 3, 1, 2]
    assert steps["temperature_c"].tolist()[1:3] == [25.5, 25.5]
    assert np.allclose(steps["time_s"], [1, 2, 3, 4.5, 5.5], atol=0.02)
    with pytest.raises(KeyError):
        device.steps("nozzle")


def test_recorders_get_everything(device: AvrDevice, tmp_path: Path) -> None:
    device.sense("air", -5.0)
    with VcdRecorder(tmp_path / "x.vcd", {"heater": "PD3"}, device.avr.clock_hz) as recorder:
        device.record(recorder)
        device.advance(4.5)
        device.feed()
    text = (tmp_path / "x.vcd").read_text()
    assert text.count("\n1!") == 1  # at full power, without a pause
    assert "heater" in text
    assert device.on_fraction("heater") == pytest.approx(3.5 / 4.5, abs=0.01)


def test_a_spec_without_a_shield(device: AvrDevice) -> None:
    device.interfaces.clear()
    with pytest.raises(LookupError, match="chamber has no LcdKeypad"):
        device.press("up")


def test_two_devices_are_equal_however_they_are_advanced(chamber: Controller) -> None:
    first, second = (AvrDevice(chamber, whole("chamber")) for _ in range(2))
    first.advance(10)
    for time_s in np.linspace(0.01, 10, 77):
        second.advance(float(time_s))
    assert first.steps("air").tobytes() == second.steps("air").tobytes()
    assert first.plotter.lines == second.plotter.lines
    assert first.plotter.lines
