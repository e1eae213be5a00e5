"""`heatwright simulate --serial` of a slave: a real master finds it until Ctrl-C."""

import json
import signal
import subprocess
import sys
from pathlib import Path

from pymodbus.client import ModbusSerialClient

FABRICATOR = Path(__file__).parents[2] / "spec" / "examples" / "fabricator.yaml"
HEATWRIGHT = Path(sys.executable).parent / "heatwright"
ROOM = 200
STEP = 24
"""Tenths of a degree between two codes of the converter, there."""


def test_a_master_finds_the_slave_until_ctrl_c() -> None:
    command = [HEATWRIGHT, "simulate", FABRICATOR, "--serial", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        told = json.loads("".join(process.stdout.readline() for _ in range(5)))
        assert (told["baud"], told["speed"]) == (19200, 1.0)
        client = ModbusSerialClient(told["port"], baudrate=told["baud"], timeout=1, retries=5)
        assert client.connect()
        seen = client.read_input_registers(100, count=6)
        while seen.registers[0] == 0x8000:  # it has not measured yet
            seen = client.read_input_registers(100, count=6)
        assert abs(seen.registers[0] - ROOM) <= STEP
        counters = client.read_input_registers(10, count=6).registers
        assert counters[0] == counters[3]  # nobody else asks
        client.close()
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=20) == 0
    assert not Path(told["port"]).exists()
