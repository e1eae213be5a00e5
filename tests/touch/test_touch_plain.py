"""A machine without programs has a display too: on and off, a setpoint, gains, on the binary."""

import re
from pathlib import Path

import pytest
from touch_kiln import SPEC

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.spec import Spec, load

PLAIN = re.sub(r"programs:\n.*?interfaces:", "interfaces:", SPEC, flags=re.DOTALL)
ON_OFF = (
    PLAIN.replace("{kind: pid, kp: 7.6, ki: 0.026, kd: 51}", "{kind: on_off, hysteresis: 2 K}")
    .replace(", selectable: [K, S]", "")
    .replace("      maximum_adjustable: true\n", "")
)
BESIDE_MODBUS = PLAIN.replace("loop: chamber}", "loop: chamber, port: 1}\n  - {kind: modbus_rtu}")


class Desk:
    """The binary, and its display."""

    def __init__(self, spec: Spec, program: Elf) -> None:
        self.device = AvrDevice(spec.controller, program)
        self.device.sense("chamber", 20.0)
        self.wait(4.0)

    def wait(self, seconds: float = 3.0) -> None:
        end_s = self.device.time_s + seconds
        while self.device.time_s < end_s:
            self.device.advance(self.device.time_s + 0.1)

    def tap(self, *names: str) -> None:
        for name in names:
            self.device.display.tap(name)
            self.wait(0.3)
        self.wait()

    def shown(self, name: str) -> int | str:
        return self.device.display.value(name)


def desk(text: str, folder: Path) -> Desk:
    path = folder / "plain.yaml"
    path.write_text(text, encoding="utf-8")
    spec = load(path)
    write(render(plan_firmware(spec)), folder)
    return Desk(spec, Elf(build(folder).elf))


@pytest.fixture(scope="module")
def plain_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("plain")


def test_a_setpoint_is_typed_and_held(plain_folder: Path) -> None:
    plain = desk(PLAIN, plain_folder)
    assert plain.device.display.page == "main"
    plain.tap("bset", "bsp", "clear", "d3", "d4", "d9", "d10", "ok")  # 45.0
    assert plain.shown("settings.sp.txt") == "45.0"
    plain.tap("back", "on")
    assert plain.device.read("loop_chamber.enabled") == 1
    assert plain.shown("main.set.val") == 45
    assert plain.shown("main.state.txt") == "on"
    assert plain.device.read("loop_chamber.duty_percent") > 0
    plain.tap("bstop", "yes")
    assert plain.device.read("loop_chamber.enabled") == 0
    assert plain.shown("main.on.val") == 0
    assert plain.device.display.errors == []


def test_gains_and_a_duty_by_hand(plain_folder: Path) -> None:
    plain = desk(PLAIN, plain_folder)
    plain.tap("bdebug", "bkp", "clear", "d7", "d9", "d4", "ok")
    plain.tap("on", "bot", "d3", "d10", "ok")
    assert plain.device.read("settings.chamber_kp") == 2.5
    assert plain.shown("debug.kp.txt") == "2.5"
    assert plain.shown("debug.ot.val") == 40
    assert plain.device.display.errors == []


def test_a_switch_has_fewer_pages(plain_folder: Path) -> None:
    simple = desk(ON_OFF, plain_folder)
    simple.tap("bdebug", "on")
    assert simple.device.read("loop_chamber.enabled") == 1
    simple.tap("back", "bset")
    assert simple.shown("settings.sp.txt") == "20.0"
    assert simple.device.display.errors == []


def test_on_another_port_beside_a_master(plain_folder: Path) -> None:
    """The master's line stays its own; what starts disabled is told off before it is told on."""
    beside = desk(BESIDE_MODBUS, plain_folder)
    beside.tap("bdebug", "on")
    assert beside.device.read("loop_chamber.enabled") == 0
    assert beside.shown("debug.on.val") == 0
    beside.device.send("#2 0;")
    beside.wait()
    beside.tap("on")
    assert beside.device.read("loop_chamber.enabled") == 1
    assert beside.shown("debug.on.val") == 1
