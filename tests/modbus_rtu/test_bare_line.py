"""Examples on a bare line, to the bit: random and damaged frames, echoes, breaks and bad moments,
and a bus that is busy all the time."""

import random
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from rig.firmware import changed, controller_of, device_of
from rig.modbus_oracle import Oracle
from suite import amount
from test_slave import SHORT, pdu, requests

from heatwright.sim.device import AvrDevice
from heatwright.sim.interfaces.modbus_rtu import format_of, frames
from heatwright.sim.interfaces.modbus_rtu.bus import Bus, Frame
from heatwright.sim.interfaces.modbus_rtu.frames import crc, framed
from heatwright.sim.native.characters import Format
from heatwright.sim.native.pins import pin_number
from heatwright.sim.timing import steps, waits
from heatwright.spec import Controller, facts_of

ANSWER_S = 0.005  # an answer begins within this long after the silence that ends its request
SETTLE_CHARACTERS = 100  # what the unplugged master had on the line is over by then

CALM = {
    "fabricator": (
        ("{rise: 5 K, within: 30 s}", "off"),
        ("{above: 20 K, for: 60 s}", "off\n      frozen: off\n      rising_while_off: off"),
        (", current: {sensor: current, limit: 3 A}", ""),
        (
            "  current: {kind: current, pin: PA1, scale: 0.5 V/A, oversample: 4, "
            "tolerances: {scale: 2 %, offset: 10 mV, reference: 0.2 V}}\n",
            "",
        ),
        (", current: {of: heater}", ""),
        ("    heat: {", "    bears: {block: 700 °C, cold_end: 700 °C}\n    heat: {"),
    ),
    "dryer": (
        ("{rise: 2 K, within: 2 min}", "off"),
        ("{above: 8 K, for: 1 min}", "off\n      frozen: off\n      rising_while_off: off"),
        ("    heat: {", "    bears: {air: 200 °C, walls: 200 °C}\n    heat: {"),
    ),
}
"""The rules that judge the machine off: its temperature stands still, for nobody simulates it."""


def slave_of(
    name: str, baud: int | None = None, *replaced: tuple[str, str], warm_c: float = 45.0
) -> tuple[Controller, AvrDevice]:
    text = changed(name, *replaced)
    if baud is not None:
        text = re.sub(r"\bbaud: \d+", f"baud: {baud}", text)
    return controller_of(text), device_of(text, warm_c)


@dataclass(frozen=True)
class Sent:
    """A frame for the line: its bytes, the bits turned over in each, the silence before each, s."""

    data: bytes
    flips: tuple[int, ...] = ()
    gaps_s: tuple[float, ...] = ()
    form: Format | None = None
    baud: int | None = None


class Wire:
    """The bare line of an example: its own master is unplugged.

    address -- the slave's; frames -- what has come from the board; slowest_s -- the longest an
    answer has begun after the silence.
    """

    def __init__(
        self, name: str, baud: int | None = None, *replaced: tuple[str, str],
        warm_c: float = 45.0, start_s: float = 1.0,
    ) -> None:  # fmt: skip
        self.controller, self.device = slave_of(name, baud, *replaced, warm_c=warm_c)
        self.device.unplug()
        self.device.advance(start_s)
        self.device.avr.take_resets()  # the one by which the watchdog is proven
        interface = facts_of(self.controller).modbus
        assert interface is not None
        driver = None
        if interface.driver_enable is not None:
            driver = pin_number(self.controller.board.pins[interface.driver_enable].port_name)
        form, device = format_of(interface), self.device
        self.address = interface.address
        self.bus = Bus(device.avr, device.uart, interface.baud, form, driver)
        self.frames: list[Frame] = []
        self.slowest_s = 0.0
        device.record(self)
        self.run_to(device.avr.time_s + SETTLE_CHARACTERS * self.character_s)

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        self.frames += self.bus.feed(pins, sent)

    @property
    def character_s(self) -> float:
        return self.bus.form.bits / self.bus.baud

    def put(self, sent: Sent) -> float:
        data, gaps_s = sent.data, sent.gaps_s or 0.0
        return self.bus.send(data, form=sent.form, baud=sent.baud, gap_s=gaps_s, flips=sent.flips)

    def ask(self, sent: Sent) -> Frame | None:
        self.frames.clear()
        return self.answer_since(self.put(sent))

    def answer_since(self, end_s: float) -> Frame | None:
        self.run_to(end_s + self.bus.silence_s + ANSWER_S)
        while self.bus.hears and not self.frames:
            self.run_to(self.device.avr.time_s + self.bus.silence_s)
        if not self.frames:
            return None
        frame = self.frames.pop(0)
        self.slowest_s = max(self.slowest_s, frame.start_s - end_s - self.bus.silence_s)
        return frame

    def answers(self, pdu: bytes) -> bool:
        return self.ask(Sent(framed(self.address, pdu))) is not None

    def counter(self, name: str) -> int:
        return int(self.device.read(f"modbus_counters.{name}"))

    def run_for(self, seconds: float) -> None:
        self.run_to(self.device.avr.time_s + seconds)

    def run_to(self, time_s: float) -> None:
        self.device.avr.run_to(round(time_s * self.device.avr.clock_hz))
        self.device.feed()


RUNS = {
    ("fabricator", 115_200): 0.45, ("fabricator", 19_200): 0.07,
    ("dryer", 115_200): 0.45, ("dryer", 1_200): 0.03,
}  # fmt: skip
"""Shares of all frames; most of them as fast as they come."""
LEAST = 600
ROOM_C = 50.0
VOLATILE = {2: range(3), 4: range(3), 17: (0, 1, 2, 3, *range(5, 40))}
"""Functions whose answers tell what only the machine knows: what of them is compared."""

BITS = 11  # bits of a character: start, data, parity, stop
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


LINES = [(name, baud) for name, usual in (("fabricator", 19_200), ("dryer", 38_400))
         for baud in (1200, usual, 115_200)]  # fmt: skip
READ = frames.read(4, 0, 16)


@pytest.fixture(params=LINES, ids=lambda line: f"{line[0]}-{line[1]}")
def wire(request: pytest.FixtureRequest) -> Wire:
    return Wire(*request.param)


def request(wire: Wire, pdu: bytes = READ) -> Sent:
    return Sent(frames.framed(wire.address, pdu))


def test_an_echo_of_its_own_answer_is_no_request(wire: Wire) -> None:
    """A transceiver whose /RE is tied to ground hears what it sends."""
    answer = wire.ask(request(wire))
    assert answer is not None
    end_s = wire.put(request(wire))
    wire.run_to(end_s + wire.bus.silence_s)
    while not wire.bus.hears:
        wire.run_for(1e-4)
    wire.put(Sent(answer.data))
    assert wire.answer_since(end_s) is not None
    wire.run_for(5 * wire.character_s)
    assert wire.counter("messages") == wire.counter("requests") == 2
    assert wire.frames == []
    assert wire.answers(READ)


def test_a_line_that_is_held_low(wire: Wire) -> None:
    """A cable that is shorted, or pulled out of a port without bias."""
    wire.device.avr.uarts[wire.device.uart].send_break(1.0)
    wire.run_for(1.0 + 2 * wire.bus.silence_s)
    assert wire.counter("errors") == 1
    assert wire.answers(READ)


@pytest.mark.parametrize("at_us", range(300, 5000, 371))
def test_it_is_powered_while_others_talk(at_us: int) -> None:
    """What it meets in its middle is damaged; the next frame is not."""
    wire = Wire("fabricator", start_s=1e-6 * at_us)
    wire.device.avr.reset()
    end_s = wire.put(Sent(frames.framed(wire.address + 1, READ)))
    wire.run_to(end_s + 2 * wire.bus.silence_s)
    wire.run_for(0.1)
    assert wire.answers(READ)


@pytest.mark.parametrize("at_us", range(100, 20_000, 1771))
def test_a_reset_in_the_middle_of_anything(at_us: int) -> None:
    """During a request, the silence or the answer: driver off, and it listens again."""
    wire = Wire("dryer")
    start_s = wire.device.avr.time_s
    wire.put(request(wire))
    wire.run_to(start_s + 1e-6 * at_us)
    wire.device.avr.reset()
    wire.run_for(1e-5)
    assert not wire.device.avr.pins.level("PD2")
    wire.run_for(0.2)
    cut_off = wire.bus.unheard
    assert cut_off <= 1
    assert wire.answers(READ)
    assert wire.bus.unheard == cut_off


MASKED_US = 20.0  # interrupts off, at most
LOAD_S = float(amount("modbus_load_s"))
"""Time for each kind; a request falls at every phase of a tick, and of a control step."""
ANSWER_MS = 1.0  # A tick waits at most so long for an answer to be made
SEED = 5
REQUESTS = (
    frames.read(4, 0, 16), frames.read(4, 100, 5), frames.read(2, 100, 5), frames.read(3, 100, 1),
    frames.write_register(100, 300), frames.write_coil(100, on=True), b"\x11", b"\x2b\x0e\x02\x00",
    bytes.fromhex("17 0064 0001 0064 0001 02 012c"),
)  # fmt: skip


def asked(wire: Wire, chance: random.Random) -> None:
    assert wire.answers(chance.choice(REQUESTS))
    wire.run_for(chance.random() * 0.002)


def strangers(wire: Wire, chance: random.Random) -> None:
    data = frames.framed(wire.address + 1, pdu(chance, SHORT))
    gaps = (1.1 * wire.bus.silence_s, *(0.0,) * (len(data) - 1))
    wire.run_to(wire.put(Sent(data, gaps_s=gaps)))


def flood(wire: Wire, chance: random.Random) -> None:
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
        assert late.passed
        assert late.details["steps"] >= LOAD_S / each.period_s - 1
    files = waits.Files(device.elf)
    for figure in waits.masked(profile, files, device.avr.clock_hz, MASKED_US).values():
        assert figure.passed, figure
    assert waits.busy(profile, files).passed
    answering = profile.functions.get("modbus_answer")
    assert (answering is not None) is (load is asked)
    if answering is not None:
        assert 1000 * answering.longest / device.avr.clock_hz < ANSWER_MS
    assert device.read("fault.code") == 0 or load is not asked
    assert len(device.avr.take_resets()) == 0
