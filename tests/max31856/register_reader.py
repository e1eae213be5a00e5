"""A processor that reads and writes a chip's registers when it is told to."""

from avr_firmware import powered, shared

from heatwright.sim.avr import Avr
from heatwright.sim.dwarf import Variables
from heatwright.sim.sensors.spi_chip import Wires

WIRES = Wires("PB2", "PB0", "PB4", "PB3")
WRITE = 0x80


class RegisterReader:
    """Talks through the firmware registers.c."""

    def __init__(self) -> None:
        program = shared("registers.c")
        self.avr: Avr = powered(program)
        self._request = Variables(program)["request"]
        self.avr.run(0.0001)

    def exchange(self, sent: bytes, *, mode: int = 1, **asked: int) -> bytes:
        """Send some bytes, and return what came meanwhile; asked: late, bits_short, hold_ms."""
        self._put("bytes", sent)
        otherwise = dict.fromkeys(("late", "bits_short", "hold_ms"), 0)
        for name, value in (otherwise | asked | {"count": len(sent), "mode": mode}).items():
            self._put(name, bytes([value]))
        done = self._get("done")
        self._put("go", b"\x01")
        while self._get("done") == done:
            self.avr.run(0.0001)
        return self._get("bytes")[: len(sent)]

    def read(self, address: int, count: int, *, mode: int = 1) -> bytes:
        return self.exchange(bytes([address, *[0] * count]), mode=mode)[1:]

    def write(self, address: int, *values: int, mode: int = 1) -> None:
        self.exchange(bytes([address | WRITE, *values]), mode=mode)

    def _put(self, name: str, data: bytes) -> None:
        self.avr.write_ram(self._request.step(name).address, data)

    def _get(self, name: str) -> bytes:
        member = self._request.step(name)
        return self.avr.read_ram(member.address, member.size)
