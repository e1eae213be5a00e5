"""What a bad day brings: right requests, damaged ones, strangers' frames, noise."""

import random
import struct
from collections.abc import Iterator
from dataclasses import dataclass

from modbus_wire import Sent

from heatwright.sim.interfaces.modbus_bus import Bus
from heatwright.sim.interfaces.modbus_frames import crc, framed
from heatwright.sim.native.characters import Format

BITS = 11
"""Of a character: start, data, parity, stop."""
WORDS = (
    0, 1, 99, 100, 300, 301, 599, 700, 800, 801, 999, 1000, 1001, 3200, 3201, 0x3F80, 0x4974,
    0x2400, 0x7F80, 0x7FC0, 0x8000, 0xBF80, 0xFF00, 0xFFFF,
)  # fmt: skip
ADDRESSES = (
    0, 1, 2, 3, 15, 99, 100, 100, 100, 101, 102, 103, 104, 105, 106, 107, 108, 199, 200, 0xFFFF,
)  # fmt: skip
FUNCTIONS = (1, 2, 3, 4, 5, 5, 5, 6, 6, 6, 15, 15, 16, 16, 17, 22, 23, 43)
SHORT, LONG = 1.2, 1.5
"""Gaps inside a frame: in characters one that is borne, in silences one that ends the frame."""


@dataclass(frozen=True)
class Hostile:
    """What is sent, what of it arrives as one frame, and whether each of its bytes is undamaged.

    parts -- more than one where a gap ends a frame in its middle.
    """

    sent: Sent
    parts: tuple[bytes, ...]
    whole: bool = True


class Hostility:
    """Makes frames for a slave by chance."""

    def __init__(self, address: int, line: Bus, seed: int) -> None:
        self._address = address
        self._line = line
        self._character_s, self._silence_s = line.form.bits / line.baud, line.silence_s
        self._chance = random.Random(seed)  # noqa: S311 - no secret

    def frames(self, count: int) -> Iterator[Hostile]:
        makers = {
            self._good: 40,
            self._turned: 10,
            self._flipped: 12,
            self._cut: 6,
            self._longer: 5,
            self._noise: 8,
            self._stranger: 5,
            self._torn: 5,
            self._stretched: 4,
            self._doubled: 3,
            self._answer: 2,
            self._other_parity: 3,
            self._other_speed: 3,
        }
        for _ in range(count):
            yield self._chance.choices(list(makers), list(makers.values()))[0]()

    # -- right requests ------------------------------------------------------------------------

    def _address_near(self) -> int:
        return self._chance.choice((*ADDRESSES, self._chance.randrange(1 << 16)))

    def _word(self) -> int:
        chance = self._chance
        return chance.choice(WORDS) if chance.random() < 0.6 else chance.randrange(1 << 16)

    def pdu(self) -> bytes:
        """Return a request, often one that may be served."""
        chance = self._chance
        function = chance.choice((*FUNCTIONS, chance.randrange(1, 128)))
        makers = {
            5: self._coil,
            6: self._register,
            15: self._coils,
            16: self._registers,
            17: lambda: b"",
            22: lambda: struct.pack(">HHH", self._address_near(), self._word(), self._word()),
            23: self._both,
            43: lambda: bytes([chance.choice((14, 14, 14, 13)), *self._small(2)]),
        }
        if function in (1, 2, 3, 4):
            return bytes([function]) + self._reading()
        return bytes([function]) + makers.get(function, lambda: chance.randbytes(4))()

    def _small(self, count: int) -> list[int]:
        return [self._chance.randrange(6) for _ in range(count)]

    def _reading(self) -> bytes:
        count = self._chance.choice((1, 1, 1, 2, 2, 3, 6, 8, 9, 125, 126))
        return struct.pack(">HH", self._address_near(), count)

    def _coil(self) -> bytes:
        value = self._chance.choice((0, 0xFF00, 0xFF00, self._word()))
        return struct.pack(">HH", self._chance.choice((self._address_near(), 100, 101, 102)), value)

    def _register(self) -> bytes:
        address = self._chance.choice((self._address_near(), 100, 101))
        return struct.pack(">HH", address, self._word())

    def _coils(self) -> bytes:
        count = self._chance.choice((1, 2, 3, 4, 9))
        size = (count + 7) // 8
        head = struct.pack(">HHB", self._address_near(), count, size)
        return head + self._chance.randbytes(size)

    def _registers(self) -> bytes:
        count = self._chance.choice((1, 2, 2, 4, 6, 8, 9))
        return struct.pack(">HHB", self._address_near(), count, 2 * count) + self._words(count)

    def _both(self) -> bytes:
        count = self._chance.choice((1, 2, 2, 8))
        head = struct.pack(">HB", count, 2 * count)
        return self._reading() + struct.pack(">H", self._address_near()) + head + self._words(count)

    def _words(self, count: int) -> bytes:
        return struct.pack(f">{count}H", *(self._word() for _ in range(count)))

    def _request(self) -> bytes:
        return framed(self._chance.choice((self._address,) * 19 + (0,)), self.pdu())

    def _good(self) -> Hostile:
        data = self._request()
        return Hostile(Sent(data), (data,))

    # -- damage --------------------------------------------------------------------------------

    def _turned(self) -> Hostile:
        """Bits are turned before the characters are made: parity is right, only the CRC tells."""
        data = bytearray(self._request())
        for _ in range(self._chance.choice((1, 1, 2, 3, 8))):
            data[self._chance.randrange(len(data))] ^= 1 << self._chance.randrange(8)
        return Hostile(Sent(bytes(data)), (bytes(data),))

    def _flipped(self) -> Hostile:
        """One bit of a character is turned on its way: parity or stop bit tell."""
        data = self._request()
        flips = [0] * len(data)
        flips[self._chance.randrange(len(data))] = 1 << self._chance.randrange(1, BITS)
        return Hostile(Sent(data, tuple(flips)), (data,), whole=False)

    def _cut(self) -> Hostile:
        data = self._request()
        data = data[: self._chance.randrange(1, len(data))]
        return Hostile(Sent(data), (data,))

    def _longer(self) -> Hostile:
        """Too long for what it says, with the CRC of what it is, or without."""
        data = self._request()
        if self._chance.random() < 0.5:
            data = data[:-2] + self._chance.randbytes(self._chance.choice((1, 2, 60, 200)))
            data += crc(data)
        else:
            data += self._chance.randbytes(self._chance.choice((1, 2, 100, 300)))
        return Hostile(Sent(data), (data,))

    def _noise(self) -> Hostile:
        size = self._chance.choice((1, 2, 3, 4, 5, 8, 20, 255, 256, 257, 300))
        data = self._chance.randbytes(size)
        return Hostile(Sent(data), (data,))

    def _stranger(self) -> Hostile:
        other = self._chance.choice([n for n in range(1, 256) if n != self._address])
        data = framed(other, self.pdu())
        return Hostile(Sent(data), (data,))

    def _answer(self) -> Hostile:
        """An answer of another slave, or of one with the same address."""
        count = self._chance.randrange(1, 100)
        pdu = bytes([self._chance.choice((3, 4)), 2 * count]) + self._words(count)
        data = framed(self._chance.choice((self._address, self._address + 1)), pdu)
        return Hostile(Sent(data), (data,))

    def _torn(self) -> Hostile:
        """A silence in the middle: two frames, neither of them one."""
        data = self._request()
        at = self._chance.randrange(1, len(data))
        gaps = tuple(LONG * self._silence_s * (n == at) for n in range(len(data)))
        return Hostile(Sent(data, gaps_s=gaps), (data[:at], data[at:]))

    def _stretched(self) -> Hostile:
        """Gaps as USB adapters make them."""
        data = self._request()
        gaps = tuple(
            SHORT * self._character_s * (n > 0 and self._chance.random() < 0.3)
            for n in range(len(data))
        )
        return Hostile(Sent(data, gaps_s=gaps), (data,))

    def _doubled(self) -> Hostile:
        """Two requests without silence are one frame, and a wrong one."""
        data = self._request() + self._request()
        return Hostile(Sent(data), (data,))

    def _other_parity(self) -> Hostile:
        data = self._request()
        other = "odd" if self._line.form.parity == "even" else "even"
        return Hostile(Sent(data, form=Format(8, other)), (data,), whole=False)

    def _other_speed(self) -> Hostile:
        data = self._request()
        baud = round(self._line.baud * self._chance.choice((0.5, 0.75, 1.5, 2)))
        return Hostile(Sent(data, baud=baud), (data,), whole=False)
