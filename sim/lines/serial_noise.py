"""A noisy cable: bytes are changed, lost or doubled."""

import random

PRINTED = range(0x20, 0x7F)


class SerialNoise:
    """Disturbs a serial line in both directions, the same in every run.

    to_board_share, to_host_share -- share of the bytes that are damaged. Those to the host stay
    ASCII: Printrun's host stops reading permanently at a byte that is no UTF-8. spares -- lines to
    the host with this beginning are never damaged. is_on -- whether anything is damaged at all.
    """

    def __init__(
        self,
        *,
        to_board_share: float = 0.0,
        to_host_share: float = 0.0,
        spares: bytes | None = None,
        seed: int = 0,
    ) -> None:
        self.hits = 0
        self.is_on = True
        self._shares = (to_board_share, to_host_share)
        self._spares = spares
        self._to_host = b""
        self._chance = random.Random(seed)  # noqa: S311 - noise, no secret

    def to_board(self, data: bytes) -> bytes:
        """Return the bytes that arrive at the board."""
        return self._disturbed(data, self._shares[0], range(256))

    def to_host(self, data: bytes) -> bytes:
        """Return the bytes that arrive at the host."""
        if self._spares is None:
            return self._disturbed(data, self._shares[1], PRINTED)
        arrived = bytearray()
        for byte in (data[at : at + 1] for at in range(len(data))):
            self._to_host = byte if self._to_host.endswith(b"\n") else self._to_host + byte
            share = 0.0 if self._to_host.startswith(self._spares) else self._shares[1]
            arrived += self._disturbed(byte, share, PRINTED)
        return bytes(arrived)

    def _disturbed(self, data: bytes, share: float, values: range) -> bytes:
        if not share or not self.is_on:
            return data
        arrived = bytearray()
        for byte in data:
            if self._chance.random() >= share:
                arrived.append(byte)
                continue
            self.hits += 1
            other = self._chance.choice(values)
            arrived += self._chance.choice((b"", bytes([other]), bytes([byte, byte])))
        return bytes(arrived)
