"""Corners of the line, on the binary: echoes, breaks, and bad moments."""

import pytest
from modbus_wire import Sent, Wire

from heatwright.sim.interfaces import modbus_frames as frames

LINES = [(name, baud) for name, usual in (("fabricator", 19_200), ("dryer", 38_400))
         for baud in (1200, usual, 115_200)]  # fmt: skip
READ = frames.read(4, 0, 16)


@pytest.fixture(params=LINES, ids=lambda line: f"{line[0]}-{line[1]}")
def wire(request: pytest.FixtureRequest) -> Wire:
    return Wire(*request.param)


def request(wire: Wire, pdu: bytes = READ) -> Sent:
    return Sent(frames.framed(wire.address, pdu))


def test_a_request_within_an_answer_is_not_heard(wire: Wire) -> None:
    """One buffer serves both ways: nothing may write into an answer."""
    end_s = wire.put(request(wire))
    wire.run_to(end_s + wire.bus.silence_s + 0.001 + 3 * wire.character_s)
    wire.put(request(wire, frames.write_register(100, 400)))
    answer = wire.answer_since(end_s)
    assert answer is not None
    assert frames.answer_to(wire.address, READ, answer.data) is not None
    wire.run_for(20 * wire.character_s)
    assert wire.counter("requests") == 1
    assert wire.answers(READ)


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
    """Of a request, of the silence, of the answer: driver off, and it listens again."""
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
