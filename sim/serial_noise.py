"""A bad cable: bytes that are changed, lost or doubled on their way."""

from __future__ import annotations

import random

PRINTED = range(0x20, 0x7F)


class SerialNoise:
    """Disturbs a serial line, both ways, the same in every run.

    to_board_share, to_host_share -- of the bytes, how many are hit. On their way to the host they
    stay ASCII: Printrun's host stops listening for good at a byte that is no UTF-8.
    """

    def __init__(
        self, *, to_board_share: float = 0.0, to_host_share: float = 0.0, seed: int = 0
    ) -> None:
        self.hits = 0
        self._shares = (to_board_share, to_host_share)
        self._chance = random.Random(seed)  # noqa: S311 - noise, no secret

    def to_board(self, data: bytes) -> bytes:
        """Return what arrives at the board."""
        return self._disturbed(data, self._shares[0], range(256))

    def to_host(self, data: bytes) -> bytes:
        """Return what arrives at the host."""
        return self._disturbed(data, self._shares[1], PRINTED)

    def _disturbed(self, data: bytes, share: float, values: range) -> bytes:
        if not share:
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
