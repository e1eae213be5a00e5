"""Whatever becomes of the display, and whatever it sends: nothing but the display's own changes.

Two boards run side by side, one of them with the bytes on its line. After every tick all of their
memory is compared; what only the display's own files may write is left out. The line goes at full
speed while a program runs.
"""

import pytest
from display_orders import Grammar, Malice
from memory_guard import BAUD, Kilns
from rig.specs import example
from suite import amount

from heatwright.sim.avr import RAM_FILL

SEED = 7
TOUCHES = ("bset", "back", "bdebug", "back", "bprog", "b1", "back", "bfaults", "back")


@pytest.fixture
def kilns() -> Kilns:
    return Kilns()


@pytest.mark.parametrize(
    "name", ["random bytes", "malformed orders", "false answers", "9600", "57600", "230400"]
)
def test_nothing_but_the_displays_own_changes(kilns: Kilns, name: str) -> None:
    """False answers: pages that there are not, starts without end, errors; and other speeds."""
    malice, baud = Malice(Grammar(example("kiln").controller), SEED), BAUD
    if name == "random bytes":
        data = malice.noise(amount("display_bytes"))
    elif name == "malformed orders":
        data = b"".join(malice.orders(amount("display_orders")))
    elif name == "false answers":
        data = b"".join(malice.answers(amount("display_orders")))
    else:
        baud = int(name)
        data = malice.noise(baud // 4)
    kilns.send((data[at : at + baud // 10] for at in range(0, len(data), baud // 10)), baud)
    kilns.finish()


def test_a_line_that_is_held_low_changes_nothing(kilns: Kilns) -> None:
    kilns.board.avr.uarts[0].send_break(5.0)
    kilns.run(6.0)
    kilns.finish()


def test_a_display_that_comes_and_goes_and_is_touched_changes_nothing(kilns: Kilns) -> None:
    """The quiet one has none."""
    display = kilns.board.display
    assert display.instructions == 0, "it has heard what it was not there for"
    for seconds in (1.0, 2.0, 3.0, 30.0):
        display.plug()
        kilns.run(seconds)
        display.unplug()
        kilns.run(1.0)
    display.plug()
    kilns.run(2.0)
    for name in 4 * TOUCHES:
        display.tap(name)
        kilns.run(1.0)
    assert display.page == "main"
    kilns.finish()


@pytest.mark.parametrize(
    "name", ["program.setpoint_c", "settings.chamber_kp", "fault.code", "PORTH", "OCR1A"]
)
def test_the_guard_sees_a_byte(kilns: Kilns, name: str) -> None:
    """Any one, in any variable that is not the display's own, and any register."""
    address = kilns.board.variables[name].address
    held = kilns.board.avr.read_ram(address, 1)
    kilns.board.avr.write_ram(address, bytes([held[0] ^ 1]))
    with pytest.raises(AssertionError, match=r"difference|ticks are missing"):
        kilns.run(1.0)


def test_the_guard_sees_a_byte_below_the_stack(kilns: Kilns) -> None:
    """Nothing but the stack is ever written above the variables."""
    avr = kilns.board.avr
    before = avr.stack_used
    address = kilns.board.elf.static_ram[1] + 40
    assert avr.read_ram(address, 1)[0] == RAM_FILL
    avr.write_ram(address, b"\0")
    assert avr.stack_used > kilns.stack_bytes > before
