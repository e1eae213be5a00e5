"""The kiln behind a serial port of this computer: a display of the user's own, or its editor's."""

import os

from kiln_desk import RUNNING, Built

from heatwright.sim.device import AvrDevice
from heatwright.sim.serial_port import SerialPort

BAUD = 115_200


def heard(port: int) -> bytes:
    """What a program has got so far."""
    os.set_blocking(port, False)
    data = b""
    while True:
        try:
            data += os.read(port, 4096)
        except BlockingIOError:
            return data


def test_a_program_takes_the_place_of_the_display(kiln: Built) -> None:
    device = AvrDevice(kiln.controller, kiln.program)
    device.sense("chamber", 20.0)
    with SerialPort(device, BAUD) as port:
        program = os.open(port.name, os.O_RDWR | os.O_NOCTTY)
        device.advance(1.0)
        device.feed()
        os.write(program, b"\0\0\0\xff\xff\xff\x88\xff\xff\xff#21 0;")
        port.to_board()
        device.advance(2.0)
        device.feed()
        instructions = heard(program).split(b"\xff\xff\xff")
        assert b"bkcmd=0" in instructions
        assert b"main.temp.val=20" in instructions
        os.write(program, b"#8 1;")
        port.to_board()
        device.advance(4.0)
        device.feed()
        assert device.read("program.state") == RUNNING
        assert any(each.startswith(b"main.state.txt=") for each in heard(program).split(b"\xff"))
        os.close(program)
    assert device.display.instructions == 0
    assert not device.display.is_plugged
