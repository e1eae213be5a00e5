"""Whatever becomes of the display, the control is the same to the last bit, in the same ticks."""

import random
from collections.abc import Callable

import numpy as np
import pytest
from kiln_desk import RUNNING, Built, KilnDesk
from rig.avr import whole
from rig.specs import EXAMPLES, spec_of

from heatwright.sim.replay import replay
from heatwright.sim.trace import StepLog
from heatwright.spec.boards import BOARDS

BAUD = 115_200
RUN_S = 300.0
LATE_S = 0.005
"""A step comes within half a tick of the same step on a quiet board."""


def nothing(desk: KilnDesk) -> None:
    desk.run(RUN_S)


def unplugged(desk: KilnDesk) -> None:
    desk.run(20.0)
    desk.display.unplug()
    desk.run(RUN_S - 20.0)


def in_and_out(desk: KilnDesk) -> None:
    for number in range(20):
        (desk.display.plug if number % 2 else desk.display.unplug)()
        desk.run(RUN_S / 20)


def at_the_wrong_speed(desk: KilnDesk) -> None:
    desk.display.line.baud = 9600
    for _ in range(30):
        desk.display.send(b"#17;\xff\xff\xff" * 10)
        desk.run(RUN_S / 30)
    assert desk.display.errors or desk.display.line.garbage


def flooded(desk: KilnDesk) -> None:
    """At twice the speed: no byte arrives as it was sent."""
    chance = random.Random(3)  # noqa: S311 - no secret
    uart = desk.device.avr.uarts[0]
    for _ in range(int(RUN_S / 10)):
        uart.send(chance.randbytes(int(2 * BAUD)), 2 * BAUD)
        desk.run(10.0)


def answering(desk: KilnDesk) -> None:
    """The display answers everything, and shows one page after the other."""
    desk.device.avr.uarts[0].send(b"\xff\xff\xff" * 1000, BAUD)
    for way in ("bset", "back", "bdebug", "back", "bprog", "b1", "back", "bfaults", "back") * 8:
        desk.tap(way)
    desk.run(RUN_S - 0.6 * 72)


def held_low(desk: KilnDesk) -> None:
    desk.device.avr.uarts[0].send_break(RUN_S / 2)
    desk.run(RUN_S)


def course(kiln: Built, what: Callable[[KilnDesk], None]) -> StepLog:
    desk = KilnDesk(kiln)
    desk.run(2.0)
    desk.display.send("#8 1;")
    desk.run(2.0)
    what(desk)
    assert desk.read("program.state") == RUNNING
    assert len(desk.device.avr.take_resets()) == 0
    return desk.device.steps("chamber")


@pytest.fixture(scope="module")
def quiet(kiln: Built) -> StepLog:
    return course(kiln, nothing)


@pytest.mark.parametrize("what", [unplugged, in_and_out, at_the_wrong_speed, answering, held_low])
def test_the_control_is_the_same(
    kiln: Built, quiet: StepLog, what: Callable[[KilnDesk], None]
) -> None:
    found = course(kiln, what)
    in_time(found, quiet)
    for name in set(quiet.dtype.names or ()) - {"time_s"}:
        assert found[name].tobytes() == quiet[name].tobytes(), name


def test_a_flood_changes_nothing_of_the_law(kiln: Built, quiet: StepLog) -> None:
    """Its interrupts move the moment of a reading by microseconds, and so which conversion it is:
    what is made of the readings is the law, to the last bit."""
    found = course(kiln, flooded)
    in_time(found, quiet)
    result = replay(kiln.controller, found, "chamber")
    assert (result.ticks, result.mismatches) == (len(quiet), 0), result.first


def in_time(found: StepLog, quiet: StepLog) -> None:
    assert len(found) == len(quiet) > RUN_S
    assert np.abs(found["time_s"] - quiet["time_s"]).max() < LATE_S


@pytest.mark.parametrize(("port", "baud"), [(2, 115_200), (3, 9_600)])
def test_another_port_another_speed(port: int, baud: int) -> None:
    """With the log on port 1 and nothing on port 0; a slow line takes longer than two ticks."""
    text = (EXAMPLES / "kiln.yaml").read_text("utf-8")
    asked = "{kind: nextion, baud: 115200,"
    assert asked in text
    text = text.replace(asked, f"{{kind: nextion, port: {port}, baud: {baud},")
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
