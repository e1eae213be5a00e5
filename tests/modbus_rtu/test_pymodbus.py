"""pymodbus, as it is, and the simulated slave behind a pseudo-terminal."""

import struct
from collections.abc import Iterator

import pytest
from pymodbus.client import ModbusSerialClient
from pymodbus.pdu import ModbusPDU
from rig.firmware import controller_of
from rig.live import Cable, LiveBoard, live_board

from heatwright.sim.interfaces.modbus_rtu.registers import registers
from heatwright.sim.native.characters import Format
from heatwright.spec import digest

SLAVE = 17
BAD_VALUE = 3
SETPOINT, MANUAL_DUTY, KP = 100, 101, 102
ENABLED = 100

DRYER = controller_of("dryer")


@pytest.fixture
def slave() -> Iterator[LiveBoard]:
    with live_board("dryer", Cable(38_400, Format(8, "odd"))) as live:
        live.run(1.0)
        yield live
        assert live.ask("resets") == 0
        assert live.ask("fault.code") == 0


@pytest.fixture
def master(slave: LiveBoard) -> Iterator[ModbusSerialClient]:
    client = ModbusSerialClient(slave.port, baudrate=38_400, timeout=20, retries=0)
    assert client.connect()
    yield client
    client.close()


def good(answer: ModbusPDU) -> ModbusPDU:
    assert not answer.isError(), answer
    return answer


def words(value: float) -> list[int]:
    return list(struct.unpack(">2H", struct.pack(">f", value)))


def test_it_reads_every_register(master: ModbusSerialClient) -> None:
    read = {
        "coil": master.read_coils, "discrete_input": master.read_discrete_inputs,
        "holding_register": master.read_holding_registers,
        "input_register": master.read_input_registers,
    }  # fmt: skip
    values = {}
    for name, register in registers(DRYER).items():
        ask = read[register.table]
        found = good(ask(register.address, count=register.words, device_id=SLAVE))
        values[name] = register.value(found.registers or [int(found.bits[0])])
    assert values["map_version"] == 1
    assert values["digest"] == int(digest(DRYER), 16)
    assert values["air.setpoint"] == values["air.setpoint_in_force"] == 45
    step_k = DRYER.thermometers["air"].step_at_k(20.0, DRYER.board.mcu)
    assert values["air.temperature"] == pytest.approx(20, abs=step_k + 0.1 / 2)
    gains = DRYER.loops["air"].algorithm
    for gain in ("kp", "ki", "kd"):
        assert values[f"air.{gain}"] == pytest.approx(getattr(gains, gain))
    counters = good(master.read_input_registers(10, count=6, device_id=SLAVE)).registers
    messages = len(registers(DRYER)) + 1
    assert counters == [messages, 0, 0, messages, 0, 0]
    assert (values["air.valid"], values["air.work"], values["air.enabled"]) == (1, 0, 0)


def test_it_writes_registers_in_every_way(master: ModbusSerialClient, slave: LiveBoard) -> None:
    good(master.write_register(SETPOINT, 615, device_id=SLAVE))
    assert slave.ask("settings.air_setpoint_c") == 61.5
    good(master.write_registers(SETPOINT, [620, 250, *words(11.5)], device_id=SLAVE))
    assert slave.ask("settings.air_setpoint_c") == 62
    assert slave.ask("settings.air_kp") == 11.5
    good(master.write_registers(KP, [*words(1.5), *words(0.25), *words(99)], device_id=SLAVE))
    assert [slave.ask(f"settings.air_{gain}") for gain in ("kp", "ki", "kd")] == [1.5, 0.25, 99]
    good(master.mask_write_register(address=SETPOINT, and_mask=0xFF00, or_mask=0x0090,
                                    device_id=SLAVE))  # fmt: skip
    assert slave.ask("settings.air_setpoint_c") == pytest.approx((0x200 | 0x90) / 10)
    both = good(master.readwrite_registers(read_address=SETPOINT, read_count=2,
                                           write_address=MANUAL_DUTY, values=[777],
                                           device_id=SLAVE))  # fmt: skip
    assert both.registers == [0x290, 777]


def test_it_switches_coils_in_every_way(master: ModbusSerialClient) -> None:
    assert master.write_coil(ENABLED, True, device_id=SLAVE).exception_code == BAD_VALUE
    good(master.write_coil(ENABLED, False, device_id=SLAVE))
    good(master.write_coils(ENABLED, [True, False, True], device_id=SLAVE))
    switched = good(master.read_coils(ENABLED, count=3, device_id=SLAVE)).bits
    assert switched[:3] == [True, False, True]


def test_it_says_who_it_is(master: ModbusSerialClient) -> None:
    resting = good(master.report_device_id(device_id=SLAVE))
    assert resting.identifier == b"H\x00drye"  # pymodbus takes the last byte for the indicator
    basic = good(master.read_device_information(read_code=1, device_id=SLAVE))
    revision = f"1 {digest(DRYER)}".encode()
    assert basic.information == {0: b"heatwright", 1: b"dryer", 2: revision}
    regular = good(master.read_device_information(read_code=2, device_id=SLAVE))
    assert regular.information[4] == b"Filament dryer on a bus"
    single = good(master.read_device_information(read_code=4, object_id=1, device_id=SLAVE))
    assert single.information == {1: b"dryer"}
