"""Modbus frames: requests of a master, answers of a slave, and an exchange of both.

Written from the specification: Modbus Application Protocol 1.1b3; over serial line 1.02.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

POLYNOMIAL = 0xA001
EXCEPTION = 0x80
"""Added to the function code in an answer that refuses."""
READS_OF_BITS = (1, 2)
READS = (*READS_OF_BITS, 3, 4, 23)
WRITES = {5: 5, 6: 5, 15: 5, 16: 5, 22: 7}
"""Functions whose answer repeats this number of bytes of the request."""
TO_ALL = 0
"""The address of a broadcast, which no slave answers."""
SHORTEST = 4
LONGEST = 256


def crc(data: bytes) -> bytes:
    """Return the checksum, low byte first, as it is sent (serial line, 6.2.2)."""
    register = 0xFFFF
    for byte in data:
        register = register >> 8 ^ SHIFTED[(register ^ byte) & 0xFF]
    return struct.pack("<H", register)


def _shifted(byte: int) -> int:
    for _ in range(8):
        byte = byte >> 1 ^ (POLYNOMIAL if byte & 1 else 0)
    return byte


SHIFTED = tuple(map(_shifted, range(256)))


def framed(address: int, pdu: bytes) -> bytes:
    """Return a request or an answer with address and checksum."""
    data = bytes([address]) + pdu
    return data + crc(data)


@dataclass(frozen=True)
class Answer:
    """A slave's answer: function code and data; the exception's code, or 0."""

    pdu: bytes
    exception: int = 0

    def words(self) -> tuple[int, ...]:
        """Return the registers that were read."""
        return struct.unpack(f">{self.pdu[1] // 2}H", self.pdu[2:])

    def bits(self) -> tuple[bool, ...]:
        """Return the bits that were read, with the padding of the last byte."""
        return tuple(bool(byte >> bit & 1) for byte in self.pdu[2:] for bit in range(8))


def answer_to(address: int, pdu: bytes, frame: bytes) -> Answer | None:
    """Return the answer in a frame; None if it is damaged or answers another request."""
    if not SHORTEST <= len(frame) <= LONGEST or crc(frame[:-2]) != frame[-2:]:
        return None
    found = frame[1:-2]
    if frame[0] != address or found[0] & ~EXCEPTION != pdu[0]:
        return None
    if found[0] & EXCEPTION:
        return Answer(found, found[1]) if len(found) == 2 else None
    return Answer(found) if _fits(pdu, found) else None


def _fits(asked: bytes, found: bytes) -> bool:
    """Return whether an answer has the right length, and repeats what it must of the request."""
    function = asked[0]
    if function in READS:
        count = int.from_bytes(asked[3:5], "big")
        size = (count + 7) // 8 if function in READS_OF_BITS else 2 * count
        return found[1:2] == bytes([size]) and len(found) == 2 + size
    if function in WRITES:
        return found == asked[: WRITES[function]]
    return True


def read(function: int, first: int, count: int) -> bytes:
    """Return a request for coils (1), discrete inputs (2), holding (3) or input registers (4)."""
    return struct.pack(">BHH", function, first, count)


def write_coil(address: int, *, on: bool) -> bytes:
    """Return a request that switches a coil."""
    return struct.pack(">BHH", 5, address, 0xFF00 if on else 0)


def write_register(address: int, word: int) -> bytes:
    """Return a request that writes a holding register."""
    return struct.pack(">BHH", 6, address, word & 0xFFFF)


def write_registers(address: int, words: Sequence[int]) -> bytes:
    """Return a request that writes consecutive holding registers."""
    count = len(words)
    return struct.pack(f">BHHB{count}H", 16, address, count, 2 * count, *words)


@dataclass
class Exchange:
    """A request and its answer.

    address -- the slave's address; pdu -- bytes of the request; writes -- the name of the written
    value, empty if it is no write by name; sends -- how often it may still be sent; sent_s -- end
    of its last bit; answer -- the answer, None before it comes, and if it has not come when `done`;
    delay_s -- time from the end of the silence after the request to the answer's first bit;
    polls -- whether it is one of the master's polls; again -- whether it is the second try to
    switch on.
    """

    address: int
    pdu: bytes
    writes: str = ""
    sends: int = 1
    polls: bool = False
    again: bool = False
    sent_s: float | None = None
    answer: Answer | None = None
    delay_s: float | None = None
    done: bool = False

    @property
    def refusal(self) -> int:
        """The exception's code; 0: none."""
        return self.answer.exception if self.answer else 0
