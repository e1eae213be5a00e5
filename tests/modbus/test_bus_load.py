"""A bus that is busy all the time: when answers come, and what of it the control steps feel."""

import random
from collections.abc import Callable

import pytest
from modbus_host import SHORT, pdu
from modbus_wire import ANSWER_S, Sent, Wire
from suite import amount

from heatwright.sim.interfaces import modbus_frames as frames
from heatwright.sim.timing import steps, waits
from heatwright.sim.timing.figures import JITTER_US

LOAD_S = float(amount("modbus_load_s"))
"""Of each kind; a request falls at every phase of a tick, and of a control step."""
ANSWER_MS = 1.0
"""A tick waits at most so long for an answer to be made."""
SEED = 5
REQUESTS = (
    frames.read(4, 0, 16), frames.read(4, 100, 5), frames.read(2, 100, 5), frames.read(3, 100, 1),
    frames.write_register(100, 300), frames.write_coil(100, on=True), b"\x11", b"\x2b\x0e\x02\x00",
    bytes.fromhex("17 0064 0001 0064 0001 02 012c"),
)  # fmt: skip


def asked(wire: Wire, chance: random.Random) -> None:
    """One request after the other, each at once after the last one's answer, of a working loop."""
    assert wire.answers(chance.choice(REQUESTS))
    wire.run_for(chance.random() * 0.002)


def strangers(wire: Wire, chance: random.Random) -> None:
    """Frames of other slaves, one after the other with nothing but their silence between."""
    data = frames.framed(wire.address + 1, pdu(chance, SHORT))
    gaps = (1.1 * wire.bus.silence_s, *(0.0,) * (len(data) - 1))
    wire.run_to(wire.put(Sent(data, gaps_s=gaps)))


def flood(wire: Wire, chance: random.Random) -> None:
    """Bytes without any silence."""
    wire.run_to(wire.put(Sent(chance.randbytes(500))))


@pytest.mark.parametrize("load", [asked, strangers, flood])
@pytest.mark.parametrize(
    ("name", "baud"),
    [("fabricator", 1200), ("fabricator", 19_200), ("fabricator", 115_200), ("dryer", 115_200)],
)
def test_control_is_as_punctual_as_ever(
    load: Callable[[Wire, random.Random], None], name: str, baud: int
) -> None:
    wire, chance = Wire(name, baud), random.Random(SEED)  # noqa: S311 - no secret
    device, loops = wire.device, wire.controller.loops
    profile = device.avr.profile(device.elf)
    steps.trace(profile, device.elf, list(loops))
    if load is asked:
        assert wire.answers(frames.write_coil(100, on=False))
    end_s = device.avr.time_s + LOAD_S
    while device.avr.time_s < end_s:
        load(wire, chance)
    assert wire.slowest_s <= ANSWER_S
    for loop, each in loops.items():
        entries = profile.entries(steps.STEP.format(loop=loop))
        late = steps.jitter(entries, each.period_s, device.avr.clock_hz, loop)
        assert late.worst is not None
        assert late.worst < JITTER_US
        assert late.details["steps"] >= LOAD_S / each.period_s - 1
    files = waits.Files(device.elf)
    for figure in waits.masked(profile, files, device.avr.clock_hz).values():
        assert figure.passed, figure
    assert waits.busy(profile, files).passed
    answering = profile.functions.get("modbus_answer")
    assert (answering is not None) is (load is asked)
    if answering is not None:
        assert 1000 * answering.longest / device.avr.clock_hz < ANSWER_MS
    assert device.read("fault.code") == 0 or load is not asked
    assert len(device.avr.take_resets()) == 0


def test_an_answer_comes_in_time_whatever_the_tick_does() -> None:
    """The silence of requests ends at two hundred phases of a tick, in control steps or not."""
    wire = Wire("fabricator")
    data = frames.framed(1, frames.read(4, 100, 6))
    took_s = len(data) * wire.character_s + wire.bus.silence_s
    for number in range(400):
        at_s = 2.0 + number * 0.1 + (number % 200) * 50e-6
        wire.run_to(at_s - took_s)
        assert wire.ask(Sent(data)) is not None
    assert wire.slowest_s <= ANSWER_S
