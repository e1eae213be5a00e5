"""What a bad day brings: right requests, damaged ones, strangers' frames, noise."""

import random
from collections.abc import Iterator
from dataclasses import dataclass

from modbus_requests import SHORT, pdu
from modbus_wire import Sent

from heatwright.sim.interfaces.modbus_bus import Bus
from heatwright.sim.interfaces.modbus_frames import crc, framed
from heatwright.sim.native.characters import Format

BITS = 11
"""Of a character: start, data, parity, stop."""
BORNE, ENDING = 1.2, 1.5
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
            self._request: 40,
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
            made = self._chance.choices(list(makers), list(makers.values()))[0]()
            yield made if isinstance(made, Hostile) else Hostile(Sent(made), (made,))

    def _request(self) -> bytes:
        return framed(self._chance.choice((self._address,) * 19 + (0,)), pdu(self._chance, SHORT))

    # -- bytes, that arrive as they are ----------------------------------------------------------

    def _turned(self) -> bytes:
        """Bits are turned before the characters are made: parity is right, only the CRC tells."""
        data = bytearray(self._request())
        for _ in range(self._chance.choice((1, 1, 2, 3, 8))):
            data[self._chance.randrange(len(data))] ^= 1 << self._chance.randrange(8)
        return bytes(data)

    def _cut(self) -> bytes:
        data = self._request()
        return data[: self._chance.randrange(1, len(data))]

    def _longer(self) -> bytes:
        """Too long for what it says, with the CRC of what it is, or without."""
        data = self._request()
        if self._chance.random() < 0.5:
            data = data[:-2] + self._chance.randbytes(self._chance.choice((1, 2, 60, 200)))
            return data + crc(data)
        return data + self._chance.randbytes(self._chance.choice((1, 2, 100, 300)))

    def _noise(self) -> bytes:
        return self._chance.randbytes(
            self._chance.choice((1, 2, 3, 4, 5, 8, 20, 255, 256, 257, 300))
        )

    def _stranger(self) -> bytes:
        other = self._chance.choice([n for n in range(1, 256) if n != self._address])
        return framed(other, pdu(self._chance, SHORT))

    def _answer(self) -> bytes:
        """An answer of another slave, or of one with the same address."""
        count = self._chance.randrange(1, 100)
        said = bytes([self._chance.choice((3, 4)), 2 * count]) + self._chance.randbytes(2 * count)
        return framed(self._chance.choice((self._address, self._address + 1)), said)

    def _doubled(self) -> bytes:
        """Two requests without silence are one frame, and a wrong one."""
        return self._request() + self._request()

    # -- damage on the way -----------------------------------------------------------------------

    def _flipped(self) -> Hostile:
        """One bit of a character is turned on its way: parity or stop bit tell."""
        data = self._request()
        flips = [0] * len(data)
        flips[self._chance.randrange(len(data))] = 1 << self._chance.randrange(1, BITS)
        return Hostile(Sent(data, tuple(flips)), (data,), whole=False)

    def _torn(self) -> Hostile:
        """A silence in the middle: two frames, neither of them one."""
        data = self._request()
        at = self._chance.randrange(1, len(data))
        gaps = tuple(ENDING * self._silence_s * (n == at) for n in range(len(data)))
        return Hostile(Sent(data, gaps_s=gaps), (data[:at], data[at:]))

    def _stretched(self) -> Hostile:
        """Gaps as USB adapters make them."""
        data = self._request()
        gaps = tuple(
            BORNE * self._character_s * (n > 0 and self._chance.random() < 0.3)
            for n in range(len(data))
        )
        return Hostile(Sent(data, gaps_s=gaps), (data,))

    def _other_parity(self) -> Hostile:
        data = self._request()
        other = "odd" if self._line.form.parity == "even" else "even"
        return Hostile(Sent(data, form=Format(8, other)), (data,), whole=False)

    def _other_speed(self) -> Hostile:
        data = self._request()
        baud = round(self._line.baud * self._chance.choice((0.5, 0.75, 1.5, 2)))
        return Hostile(Sent(data, baud=baud), (data,), whole=False)
