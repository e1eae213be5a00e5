"""A converter on its wires, and a processor that reads it when it is told to."""

from typing import Any

from rig.avr import SHARED
from rig.small import Small

from heatwright.sim.sensors.max6675 import Max6675
from heatwright.sim.sensors.max31855 import Max31855
from heatwright.sim.sensors.max31856 import Max31856
from heatwright.sim.sensors.spi_chip import Wires

WIRES = Wires("PB2", "PB0", "PB4", "PB3")
THREE_WIRES = Wires("PB2", "PB0", "PB4")
WRITE = 0x80
KINDS = {"max6675": Max6675, "max31855": Max31855, "max31856": Max31856}
BITS = {"max6675": 16, "max31855": 32}
REGISTERS = (
    "CR0", "CR1", "MASK", "CJHF", "CJLF", "LTHFTH", "LTHFTL", "LTLFTH", "LTLFTL", "CJTO",
    "CJTH", "CJTL", "LTCBH", "LTCBM", "LTCBL", "SR",
)  # fmt: skip
POWER_ON = bytes.fromhex("00 03 FF 7F C0 7F FF 80 00 00 00 00 00 00 00 00")
TYPES = "BEJKNRST"
"""By their codes."""
AUTO, FIFTY = 0x80, 1
FIRST_S, NEXT_S = 0.185, 0.110


class Reader(Small):
    """Talks with a chip over three or four wires, by the variable `request` of registers.c."""

    def __init__(self) -> None:
        super().__init__((SHARED / "registers.c").read_text("utf-8"), seconds=0.0001)

    def exchange(self, *sent: int, mode: int = 1, **how: int) -> bytes:
        usual = {"late": 0, "bits_short": 0, "hold_ms": 0, "floats": 0} | how
        done = self["request.done"]
        for name, value in (usual | {"count": len(sent), "mode": mode}).items():
            self[f"request.{name}"] = value
        self["request.bytes"] = sent
        self["request.go"] = 1
        while self["request.done"] == done:
            self.avr.run(0.0001)
        return bytes(self["request.bytes"][: len(sent)])

    def read(self, bits: int, *, hold_ms: int = 0, pull_up: bool = True) -> int:
        """Read so many bits over three wires, most significant first; keep CS low for a while."""
        how = {"bits_short": -bits % 8, "hold_ms": hold_ms, "floats": not pull_up}
        *whole, last = self.exchange(*[0] * -(-bits // 8), mode=0, **how)
        return int.from_bytes(whole) << 8 - how["bits_short"] | last


class Bench:
    def __init__(self, kind: str, **more: Any) -> None:
        self.kind = kind
        by_registers = kind == "max31856"
        self.reader = Reader()
        self.run = self.reader.avr.run
        wires = WIRES if by_registers else THREE_WIRES
        self.chip: Any = KINDS[kind](self.reader.avr, wires, **more)

    def word(self, **how: Any) -> int:
        return self.reader.read(BITS[self.kind], **how)

    def read(self, register: str, count: int, **how: int) -> bytes:
        return self.reader.exchange(REGISTERS.index(register), *[0] * count, **how)[1:]

    def write(self, register: str, *values: int, **how: int) -> None:
        self.reader.exchange(REGISTERS.index(register) | WRITE, *values, **how)

    def begin(self, letter: str = "", *, cr0: int = AUTO | FIFTY) -> None:
        """Let it convert, and wait for the first one."""
        if letter:
            self.write("CR1", TYPES.index(letter))
        self.write("CR0", cr0)
        self.run(FIRST_S + 0.002)

    def celsius(self) -> float:
        """Return the tip's temperature, as the data sheet's memory maps have it."""
        if self.kind == "max31856":
            return (_signed(self.read("LTCBH", 3)) >> 5) / 128
        word = self.word()
        return (word >> 3 & 0xFFF) / 4 if self.kind == "max6675" else code_of(word) / 4

    def junction(self) -> float:
        return (_signed(self.read("CJTH", 2)) >> 2) / 64


def code_of(word: int) -> int:
    return _signed(word.to_bytes(4, "big")) >> 18


def _signed(found: bytes) -> int:
    return int.from_bytes(found, "big", signed=True)
