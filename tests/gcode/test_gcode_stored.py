"""A setpoint that a host commands and that is kept over a loss of power."""

from pathlib import Path

import pytest

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.spec import load

EXTRUDER = Path(__file__).parents[2] / "spec" / "examples" / "extruder.yaml"
STORED_S = 10.0
"""A new setpoint is stored so long after the last change."""
RECORD_S = 0.5
"""A record's bytes, one a tick."""


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> AvrDevice:
    """An extruder that heats to a setpoint it has stored."""
    folder = tmp_path_factory.mktemp("stored")
    file = folder / "extruder.yaml"
    text = EXTRUDER.read_text(encoding="utf-8")
    file.write_text(text.replace("maximum: 260 °C}", "maximum: 260 °C, stored: true}"), "utf-8")
    spec = load(file)
    write(render(plan_firmware(spec)), folder / "firmware")
    device = AvrDevice(spec.controller, Elf(build(folder / "firmware").elf))
    device.sense("nozzle", 20.0)
    say(device, "M104 S200", 1.0 + STORED_S + RECORD_S)
    return device


def say(device: AvrDevice, line: str, seconds: float) -> None:
    device.send(line)
    device.advance(device.time_s + seconds)


def restart(device: AvrDevice) -> None:
    device.power_cycle()
    device.sense("nozzle", 20.0)
    device.advance(device.time_s + 1.0)


def test_it_is_taken_again_and_off_is_stored_at_once(stored: AvrDevice) -> None:
    restart(stored)
    assert stored.read("settings.nozzle_setpoint_c") == 200.0
    say(stored, "M104 S0", RECORD_S)
    restart(stored)
    assert stored.read("settings.nozzle_setpoint_c") == 0.0
    assert stored.on_fraction("heater") == 0.0
