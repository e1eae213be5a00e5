"""A serial port with the slave of this computer at its other end."""

import subprocess
from pathlib import Path

from slave_world import frame, value


class SlavePort:
    """Each write is a request; what is read is its answer, or nothing."""

    def __init__(self, program: Path) -> None:
        self._slave = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self._answer = b""
        self.asked: list[bytes] = []
        self.damage = 0
        """Flipped in the last byte of the answers to come."""

    def write(self, data: bytes, /) -> int:
        self.asked.append(data)
        self._say(frame(data))
        size = int.from_bytes(self._out(2), "little")
        answer = bytearray(self._out(size))
        if answer:
            answer[-1] ^= self.damage
        self._answer = bytes(answer)
        return len(data)

    def read(self, size: int, /) -> bytes:
        data, self._answer = self._answer[:size], self._answer[size:]
        return data

    def set(self, what: str, number: float) -> None:
        """Set a value of the slave's world."""
        self._say(value(what, number))

    def close(self) -> None:
        self._slave.communicate()

    def _say(self, data: bytes) -> None:
        assert self._slave.stdin is not None
        self._slave.stdin.write(data)
        self._slave.stdin.flush()

    def _out(self, size: int) -> bytes:
        assert self._slave.stdout is not None
        return self._slave.stdout.read(size)
