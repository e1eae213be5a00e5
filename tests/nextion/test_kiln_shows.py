"""What the board tells the display, on the binary and at the speed of its line."""

import os

import pytest
from kiln_desk import RUNNING, Built, KilnDesk
from rig.avr import whole
from rig.specs import changed, spec_of

from heatwright.sim.device import AvrDevice
from heatwright.sim.serial_port import SerialPort
from heatwright.spec.boards import BOARDS

BAUD = 115_200


@pytest.mark.parametrize(
    ("baud", "heard"), [(113_000, True), (119_000, True), (100_000, False), (57_600, False)]
)
def test_a_display_hears_what_it_can_sample(kiln: Built, baud: int, heard: bool) -> None:
    """The board's clock gives 117 647 baud for 115 200; each bit is sampled in its middle."""
    desk = KilnDesk(kiln)
    desk.display.line.baud = baud
    desk.run(3.0)
    assert any(each.text == "bkcmd=0" for each in desk.display.history) is heard
    assert (desk.display.errors == []) is (desk.display.instructions == 0 or heard)


@pytest.mark.parametrize(("port", "baud"), [(2, 115_200), (3, 9_600)])
def test_another_port_another_speed(port: int, baud: int) -> None:
    """With the log on port 1 and nothing on port 0; a slow line takes longer than two ticks."""
    line = f"{{kind: nextion, port: {port}, baud: {baud},"
    text = changed("kiln", ("{kind: nextion, baud: 115200,", line))
    desk = KilnDesk(Built(spec_of(text).controller, whole(text)))
    desk.run(4.0)
    assert BOARDS["mega2560"].uarts[port].number == desk.device.uart == port
    assert desk.shows("main.temp.val") == 20
    assert desk.display.errors == []
    desk.tap("bprog", "s1")
    desk.run(1.0)
    assert desk.read("program.state") == RUNNING
    late = [text for text, _ in desk.display.errors]
    assert all(text.startswith("programs.") for text in late), "said as its page was left"


def heard_on(port: int) -> bytes:
    """What a program has got so far."""
    os.set_blocking(port, False)
    data = b""
    while True:
        try:
            data += os.read(port, 4096)
        except BlockingIOError:
            return data


def test_a_program_takes_the_place_of_the_display(kiln: Built) -> None:
    """Behind a serial port of this computer: a display of the user's own, or its editor's."""
    device = AvrDevice(*kiln)
    device.sense("chamber", 20.0)
    with SerialPort(device, BAUD) as port:
        program = os.open(port.name, os.O_RDWR | os.O_NOCTTY)

        def answer(data: bytes, until_s: float) -> list[bytes]:
            os.write(program, data)
            port.to_board()
            device.advance(until_s)
            device.feed()
            return heard_on(program).split(b"\xff\xff\xff")

        device.advance(1.0)
        device.feed()
        instructions = answer(b"\0\0\0\xff\xff\xff\x88\xff\xff\xff#21 0;", 2.0)
        assert {b"bkcmd=0", b"main.temp.val=20"} <= set(instructions)
        assert any(each.startswith(b"main.state.txt=") for each in answer(b"#8 1;", 4.0))
        assert device.read("program.state") == RUNNING
        os.close(program)
    assert device.display.instructions == 0
    assert not device.display.is_plugged
