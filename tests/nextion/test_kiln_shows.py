"""What the board tells the display, on the binary and at the speed of its line."""

import pytest
from kiln_desk import RUNNING, KilnDesk
from rig.specs import changed

from heatwright.spec.boards import BOARDS


@pytest.mark.parametrize(
    ("baud", "heard"), [(113_000, True), (119_000, True), (100_000, False), (57_600, False)]
)
def test_a_display_hears_what_it_can_sample(baud: int, heard: bool) -> None:
    """The board's clock gives 117 647 baud for 115 200; each bit is sampled in its middle."""
    desk = KilnDesk()
    desk.display.line.baud = baud
    desk.run(3.0)
    assert any(each.text == "bkcmd=0" for each in desk.display.history) is heard
    assert (desk.display.errors == []) is (desk.display.instructions == 0 or heard)


@pytest.mark.parametrize(("port", "baud"), [(2, 115_200), (3, 9_600)])
def test_another_port_another_speed(port: int, baud: int) -> None:
    """With the log on port 1 and nothing on port 0; a slow line takes longer than two ticks."""
    line = f"{{kind: nextion, port: {port}, baud: {baud},"
    text = changed("kiln", ("{kind: nextion, baud: 115200,", line))
    desk = KilnDesk(text)
    desk.run(4.0)
    assert BOARDS["mega2560"].uarts[port].number == desk.device.uart == port
    assert desk.shows("main.temp.val") == 20
    assert desk.display.errors == []
    desk.tap("bprog", "s1")
    desk.run(1.0)
    assert desk.read("program.state") == RUNNING
    late = [text for text, _ in desk.display.errors]
    assert all(text.startswith("programs.") for text in late), "said as its page was left"
