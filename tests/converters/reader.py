"""A processor that reads a converter when it is told to."""

from avr_firmware import powered, shared

from heatwright.sim.avr import Avr
from heatwright.sim.dwarf import Variables
from heatwright.sim.sensors.spi_chip import Wires

WIRES = Wires("PB2", "PB0", "PB4")


class Reader:
    """Reads through the firmware converter.c."""

    def __init__(self) -> None:
        program = shared("converter.c")
        self.avr: Avr = powered(program)
        self.request = Variables(program)["request"]
        self.avr.run(0.0001)

    def read(self, bits: int, *, hold_ms: int = 0, pull_up: bool = True) -> int:
        """Read so many bits, keep CS low for a while, and return them."""
        for name, value in (("bits", bits), ("hold_ms", hold_ms), ("pull_up", pull_up), ("go", 1)):
            self.avr.write_ram(self.request.step(name).address, bytes([value]))
        done = self.field("done")
        while self.field("done") == done:
            self.avr.run(0.0001)
        return self.field("word")

    def field(self, name: str) -> int:
        member = self.request.step(name)
        return int.from_bytes(self.avr.read_ram(member.address, member.size), "little")
