"""The generated client: typed, documented, and right about every register."""

import ast
import importlib.util
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from modbus_host import ADDRESS, SLAVE, frame, value
from rig.specs import files_of, spec_of

from heatwright.generator.plan.registers import register_map

CLIENT = "client/shape_client.py"


class SlavePort:
    """A port with the slave of this computer behind it: a write is a request, what is read its
    answer, or nothing."""

    def __init__(self, program: Path) -> None:
        self._slave = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self._answer = b""
        self.asked: list[bytes] = []
        self.damage = 0
        """Flipped in the last byte of the answers to come."""

    def write(self, data: bytes, /) -> int:
        self.asked.append(data)
        self._say(frame(data))
        size = int.from_bytes(self._out(2), "little")
        answer = bytearray(self._out(size))
        if answer:
            answer[-1] ^= self.damage
        self._answer = bytes(answer)
        return len(data)

    def read(self, size: int, /) -> bytes:
        data, self._answer = self._answer[:size], self._answer[size:]
        return data

    def set(self, what: str, number: float) -> None:
        """Set a value of the slave's world."""
        self._say(value(what, number))

    def close(self) -> None:
        self._slave.communicate()

    def _say(self, data: bytes) -> None:
        assert self._slave.stdin is not None
        self._slave.stdin.write(data)
        self._slave.stdin.flush()

    def _out(self, size: int) -> bytes:
        assert self._slave.stdout is not None
        return self._slave.stdout.read(size)


@pytest.fixture(scope="module")
def module(tmp_path_factory: pytest.TempPathFactory) -> ModuleType:
    path = tmp_path_factory.mktemp("client") / "shape_client.py"
    path.write_text(files_of(SLAVE)[CLIENT], encoding="utf-8")
    found = importlib.util.spec_from_file_location("shape_client", path)
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


@pytest.fixture
def port(slave_program: Path) -> Iterator[SlavePort]:
    port = SlavePort(slave_program)
    yield port
    port.close()


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
    with pytest.raises(module.Refused, match="exception 3"):
        machine.air.manual = True
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
    for what, number in WORLD.items():
        port.set(what, number)
    assert machine.air.temperature_c == -12.3
    assert machine.bed.temperature_c is None
    assert machine.bed.current_a == 3.46
    assert (machine.air.work, machine.air.heat, machine.air.cool) == (True, True, False)
    assert (machine.uptime_s, machine.air.tuning) == (70000, 2)
    port.set("fault", 6)
    port.set("fault_temperature", 285.44)
    assert (machine.fault, machine.fault_latched, machine.fault_temperature_c) == (6, True, 285.4)
    machine.acknowledge()
    assert (machine.fault, machine.acknowledgements) == (0, 1)
    port.set("fault", 6)
    machine.acknowledge()
    assert (machine.fault, machine.acknowledgements) == (0, 2)


def test_it_knows_its_firmware(machine: Any, module: ModuleType) -> None:
    machine.check()
    module.DIGEST ^= 1
    with pytest.raises(module.WrongSlave, match="it has digest"):
        machine.check()
    module.DIGEST ^= 1


@pytest.mark.parametrize("setpoint_c", [250.1, -5.1])
def test_what_is_refused_changes_nothing(
    machine: Any, module: ModuleType, setpoint_c: float
) -> None:
    with pytest.raises(module.Refused) as refused:
        machine.air.setpoint_c = setpoint_c
    assert refused.value.code == 3
    assert machine.air.setpoint_c == 20


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
