"""Corners of the line, on the binary: gaps, echoes, breaks, and bad moments."""

import pytest
from modbus_wire import Sent, Wire, powered

from heatwright.sim.interfaces import modbus_frames as frames

BORNE, ENDING = 2.5, 1.1
"""Of a gap inside a frame: characters that are borne, silences that end the frame."""
LINES = [(name, baud) for name, usual in (("fabricator", 19_200), ("dryer", 38_400))
         for baud in (1200, usual, 115_200)]  # fmt: skip
READ = frames.read(4, 0, 16)


class Slave:
    """A powered slave with a bare line."""

    def __init__(self, name: str, baud: int | None = None, start_s: float = 1.0) -> None:
        controller, self.device = powered(name, baud)
        self.device.unplug()
        self.device.advance(start_s)
        self.wire = Wire(controller, self.device)
        self.address = self.wire.address

    def request(self, pdu: bytes = READ) -> bytes:
        return frames.framed(self.address, pdu)

    def answers(self) -> bool:
        """Whether a good request is answered now."""
        return self.wire.ask(Sent(self.request())) is not None

    def counter(self, name: str) -> int:
        return int(self.device.read(f"modbus_counters.{name}"))


@pytest.fixture(params=LINES, ids=lambda line: f"{line[0]}-{line[1]}")
def slave(request: pytest.FixtureRequest) -> Slave:
    return Slave(*request.param)


def gapped(slave: Slave, gap_s: float) -> Sent:
    data = slave.request()
    return Sent(data, gaps_s=tuple(gap_s * (n == 4) for n in range(len(data))))


def test_a_short_gap_is_borne(slave: Slave) -> None:
    sent = gapped(slave, BORNE * slave.wire.character_s)
    assert slave.wire.ask(sent) is not None
    assert slave.counter("errors") == 0


def test_a_silence_ends_a_frame(slave: Slave) -> None:
    """The slave measures from the sixth sample of a stop bit: a little earlier than its end."""
    sent = gapped(slave, ENDING * slave.wire.bus.silence_s)
    assert slave.wire.ask(sent) is None
    assert slave.counter("errors") == 2
    assert slave.answers()


def test_a_request_within_an_answer_is_not_heard(slave: Slave) -> None:
    """One buffer serves both ways: nothing may write into an answer."""
    wire = slave.wire
    end_s = wire.put(Sent(slave.request()))
    wire.run_to(end_s + wire.bus.silence_s + 0.001 + 3 * wire.character_s)
    wire.put(Sent(slave.request(frames.write_register(100, 400))))
    answer = wire.answer_since(end_s)
    assert answer is not None
    assert frames.answer_to(slave.address, READ, answer.data) is not None
    wire.run_to(slave.device.avr.time_s + 20 * wire.character_s)
    assert slave.counter("requests") == 1
    assert slave.answers()


def test_an_echo_of_its_own_answer_is_no_request(slave: Slave) -> None:
    """A transceiver whose /RE is tied to ground hears what it sends."""
    wire = slave.wire
    answer = wire.ask(Sent(slave.request()))
    assert answer is not None
    end_s = wire.put(Sent(slave.request()))
    wire.run_to(end_s + wire.bus.silence_s)
    while not wire.bus.hears:
        wire.run_to(slave.device.avr.time_s + 1e-4)
    wire.put(Sent(answer.data))
    assert wire.answer_since(end_s) is not None
    wire.run_to(slave.device.avr.time_s + 5 * wire.character_s)
    assert slave.counter("messages") == slave.counter("requests") == 2
    assert wire.frames == []
    assert slave.answers()


def test_a_line_that_is_held_low(slave: Slave) -> None:
    """A cable that is shorted, or pulled out of a port without bias."""
    slave.device.avr.uarts[slave.device.uart].send_break(1.0)
    slave.wire.run_to(slave.device.avr.time_s + 1.0 + 2 * slave.wire.bus.silence_s)
    assert slave.counter("errors") == 1
    assert slave.answers()


@pytest.mark.parametrize("at_us", range(300, 5000, 371))
def test_it_is_powered_while_others_talk(at_us: int) -> None:
    """What it meets in its middle is damaged; the next frame is not."""
    slave = Slave("fabricator", start_s=1e-6 * at_us)
    slave.device.avr.reset()
    wire = slave.wire
    end_s = wire.put(Sent(frames.framed(slave.address + 1, READ)))
    wire.run_to(end_s + 2 * wire.bus.silence_s)
    wire.run_to(slave.device.avr.time_s + 0.1)
    assert slave.answers()


@pytest.mark.parametrize("at_us", range(100, 20_000, 1771))
def test_a_reset_in_the_middle_of_anything(at_us: int) -> None:
    """Of a request, of the silence, of the answer: driver off, and it listens again."""
    slave = Slave("dryer")
    wire = slave.wire
    start_s = slave.device.avr.time_s
    wire.put(Sent(slave.request()))
    wire.run_to(start_s + 1e-6 * at_us)
    slave.device.avr.reset()
    wire.run_to(slave.device.avr.time_s + 1e-5)
    assert not slave.device.avr.pins.level("PD2")
    wire.run_to(slave.device.avr.time_s + 0.2)
    cut_off = wire.bus.unheard
    assert cut_off <= 1
    assert slave.answers()
    assert wire.bus.unheard == cut_off
