"""Random and damaged frames against the binary: no wrong answer, write, tick or reset."""

import random
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest
from modbus_host import SHORT, requests
from modbus_wire import CALM, Sent, Wire
from rig.modbus_oracle import Oracle
from suite import amount

from heatwright.sim.interfaces.modbus_frames import crc, framed
from heatwright.sim.native.characters import Format

RUNS = {
    ("fabricator", 115_200): 0.45,
    ("fabricator", 19_200): 0.07,
    ("dryer", 115_200): 0.45,
    ("dryer", 1_200): 0.03,
}
"""Shares of all frames; most of them as fast as they come."""
LEAST = 300
ROOM_C = 50.0
VOLATILE = {2: range(3), 4: range(3), 17: (0, 1, 2, 3, *range(5, 40))}
"""Functions whose answers tell what only the machine knows: what of them is compared."""


BITS = 11
"""Of a character: start, data, parity, stop."""
BORNE, ENDING = 2.5, 1.1
"""Gaps inside a frame: in characters one that is borne, in silences one that ends the frame."""


class Hostile(NamedTuple):
    """What is sent, what of it arrives as one frame, and whether each of its bytes is undamaged.

    parts -- more than one where a gap ends a frame in its middle.
    """

    sent: Sent
    parts: tuple[bytes, ...]
    whole: bool = True


def hostile_frames(wire: Wire, seed: int, count: int) -> Iterator[Hostile]:
    """Yield right and wrong requests, and what happens to them on the way."""
    chance = random.Random(seed)  # noqa: S311 - no secret
    other_form = Format(8, "odd" if wire.bus.form.parity == "even" else "even")
    for data in requests(seed, count, wire.address, SHORT):
        size, kind = len(data), chance.randrange(100)
        if kind < 12:  # one bit of a character is turned: parity or stop bit tell
            at, flip = chance.randrange(size), 1 << chance.randrange(1, BITS)
            flips = tuple(flip * (n == at) for n in range(size))
            yield Hostile(Sent(data, flips), (data,), whole=False)
        elif kind < 17:  # a silence in the middle: two frames
            at = chance.randrange(size)
            gaps = tuple(ENDING * wire.bus.silence_s * (0 < n == at) for n in range(size))
            yield Hostile(Sent(data, gaps_s=gaps), (data[:at], data[at:]))
        elif kind < 21:  # gaps as USB adapters make them
            short_s = BORNE * wire.character_s
            gaps = tuple(short_s * (n > 0 and chance.random() < 0.3) for n in range(size))
            yield Hostile(Sent(data, gaps_s=gaps), (data,))
        elif kind < 24:
            yield Hostile(Sent(data, form=other_form), (data,), whole=False)
        elif kind < 27:
            baud = round(wire.bus.baud * chance.choice((0.5, 0.75, 1.5, 2)))
            yield Hostile(Sent(data, baud=baud), (data,), whole=False)
        elif kind < 30:  # two requests without silence are one frame, and a wrong one
            yield Hostile(Sent(data + data), (data + data,))
        elif kind < 32:  # an answer of another slave, or of one with the same address
            words = chance.randbytes(2 * chance.randrange(1, 100))
            said = bytes([chance.choice((3, 4)), len(words)]) + words
            answer = framed(wire.address + chance.randrange(2), said)
            yield Hostile(Sent(answer), (answer,))
        else:
            yield Hostile(Sent(data), (data,))


def compare(got: bytes, wanted: bytes) -> bool:
    if not got or not wanted or wanted[1] not in VOLATILE:
        return got == wanted
    right = len(got) == len(wanted) and crc(got[:-2]) == got[-2:]
    return right and all(got[n] == wanted[n] for n in VOLATILE[wanted[1]] if n < len(wanted) - 2)


@pytest.mark.parametrize(("name", "baud"), RUNS)
def test_whatever_arrives(name: str, baud: int) -> None:
    frames = max(LEAST, round(amount("modbus_frames_binary") * RUNS[name, baud]))
    wire = Wire(name, baud, *CALM[name], warm_c=ROOM_C)
    device, oracle = wire.device, Oracle(wire.controller)
    ((loop, control),) = oracle.loops.items()
    answered = 0
    for number, hostile in enumerate(hostile_frames(wire, baud, frames)):
        answers = [oracle.hear(part, whole=hostile.whole) for part in hostile.parts]
        wanted = next(filter(None, answers), b"")
        frame = wire.ask(hostile.sent)
        got = b"" if frame is None else frame.data
        assert compare(got, wanted), f"{number}: {hostile}: {got!r}, not {wanted!r}"
        answered += got != b""
        if number % 100 == 0:
            for what, right in {"setpoint_c": control.setpoint, **control.gains}.items():
                assert device.read(f"settings.{loop}_{what}") == right, f"{number}: {what}"
    assert answered > frames / 3
    assert oracle.changes > frames / 100
    assert wire.slowest_s <= 0.005
    assert len(device.avr.take_resets()) == 0
    assert device.read("fault.code") == 0
    times_s, period_s = device.steps(loop)["time_s"], wire.controller.loops[loop].period_s
    assert abs(len(times_s) - device.time_s / period_s) <= 2
    assert np.max(np.abs(np.diff(times_s) - period_s)) < 0.001
