"""The generated client: typed, documented, and right about every register."""

import ast
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from modbus_host import ADDRESS, SLAVE
from rig.modbus_oracle import Oracle
from rig.specs import controller_of, files_of, spec_of

from heatwright.generator.plan.registers import register_map

CLIENT = "client/shape_client.py"


class SlavePort:
    """A port with the oracle behind it: a write is a request, what is read its answer, or none.

    damage -- flipped in the last byte of the answers to come.
    """

    def __init__(self) -> None:
        self.oracle = Oracle(controller_of(SLAVE))
        self.asked: list[bytes] = []
        self.damage = 0
        self._answer = b""

    def write(self, data: bytes, /) -> int:
        self.asked.append(data)
        answer = self.oracle.hear(data)
        self._answer = answer[:-1] + bytes(byte ^ self.damage for byte in answer[-1:])
        return len(data)

    def read(self, size: int, /) -> bytes:
        data, self._answer = self._answer[:size], self._answer[size:]
        return data


@pytest.fixture(scope="module")
def module() -> ModuleType:
    module = ModuleType("shape_client")
    exec(files_of(SLAVE)[CLIENT], vars(module))  # noqa: S102 - it is ours
    return module


@pytest.fixture
def port() -> SlavePort:
    return SlavePort()


@pytest.fixture
def machine(module: ModuleType, port: SlavePort) -> Any:
    return module.ShapeClient(port)


def test_what_is_written_is_read(machine: Any) -> None:
    machine.air.setpoint_c = 123.4
    machine.air.manual_duty_percent = 43.7
    machine.air.kp, machine.air.ki, machine.air.kd = 7.5, 0.125, 0.0
    machine.bed.setpoint_c = 70.5
    assert (machine.air.setpoint_c, machine.air.manual_duty_percent) == (123.4, 43.7)
    assert (machine.air.kp, machine.air.ki, machine.air.kd) == (7.5, 0.125, 0.0)
    assert machine.bed.setpoint_c == 70.5
    machine.air.setpoint_c = -5
    assert machine.air.setpoint_c == -5


def test_a_loop_is_switched(machine: Any, module: ModuleType) -> None:
    machine.air.enabled = False
    with pytest.raises(module.Refused, match="exception 3") as refused:
        machine.air.manual = True
    assert refused.value.code == 3
    machine.air.enabled = True
    machine.air.manual = True
    assert (machine.air.enabled, machine.air.manual, machine.air.tune) == (True, True, False)
    machine.air.tune = True
    assert (machine.air.manual, machine.air.tune) == (False, True)
    machine.air.tune = False
    assert not machine.air.enabled
    with pytest.raises(module.Refused):
        machine.air.enabled = True


WORLD = {
    "air.has_reading": 1, "air.temperature": -12.34, "air.states": 3, "bed.current": 3.456,
    "uptime": 70000, "air.tuning": 2,
}  # fmt: skip


def test_the_world_is_seen(machine: Any, port: SlavePort) -> None:
    assert machine.air.temperature_c is None
    port.oracle.world |= WORLD
    assert machine.air.temperature_c == -12.3
    assert machine.bed.temperature_c is None
    assert machine.bed.current_a == 3.46
    assert (machine.air.work, machine.air.heat, machine.air.cool) == (True, True, False)
    assert (machine.uptime_s, machine.air.tuning) == (70000, 2)
    port.oracle.fault, port.oracle.world["fault_temperature"] = 6, 285.44
    assert (machine.fault, machine.fault_latched, machine.fault_temperature_c) == (6, True, 285.4)
    machine.acknowledge()
    assert (machine.fault, machine.acknowledgements) == (0, 1)
    port.oracle.fault = 6
    machine.acknowledge()
    assert (machine.fault, machine.acknowledgements) == (0, 2)


def test_it_knows_its_firmware(machine: Any, module: ModuleType) -> None:
    machine.check()
    module.DIGEST ^= 1
    with pytest.raises(module.WrongSlave, match="it has digest"):
        machine.check()
    module.DIGEST ^= 1


@pytest.mark.parametrize("value", [3276.8, -3277, float("nan"), float("inf"), 1e300])
def test_what_no_register_holds_is_not_sent(machine: Any, port: SlavePort, value: float) -> None:
    with pytest.raises(ValueError, match=r"hold|fit"):
        machine.air.setpoint_c = value
    assert port.asked == []


def test_silence_and_damage_are_told(machine: Any, module: ModuleType, port: SlavePort) -> None:
    with pytest.raises(module.NoAnswer, match="silence"):
        _ = module.ShapeClient(port, ADDRESS + 1).fault
    port.damage = 4
    with pytest.raises(module.NoAnswer):
        _ = machine.fault
    with pytest.raises(module.NoAnswer):
        machine.air.setpoint_c = 30
    port.damage = 0
    assert machine.fault == 0


def test_every_register_has_an_attribute(module: ModuleType) -> None:
    classes = {"": module.ShapeClient, "air": module.AirLoop, "bed": module.BedLoop}
    registers = register_map(spec_of(SLAVE)).registers
    for loop, kind in classes.items():
        names = [each.name.rpartition(".")[2] for each in registers
                 if each.name.rpartition(".")[0] == loop]  # fmt: skip
        there = [name for name in vars(kind) if not name.startswith("_") and name != "check"]
        assert len(there) == len(names)
        for name in names:
            assert any(each == name or each.startswith(f"{name}_") for each in there)


@pytest.mark.parametrize("name", ["lambda", "fault", "check"], ids=["keyword", "taken", "own"])
def test_it_is_typed_whatever_the_names(name: str, tmp_path: Path) -> None:
    text = SLAVE.replace("  air:\n    sensor: air", f"  {name}:\n    sensor: air")
    source = files_of(text)[CLIENT]
    ast.parse(source)
    path = tmp_path / "shape_client.py"
    path.write_text(source, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--config-file=", path.name], cwd=tmp_path,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    assert f"self.{name}_loop = " in source
