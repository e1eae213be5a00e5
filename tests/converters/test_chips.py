"""The converters against their data sheets: chips.yaml, by way of a plain reader."""

from operator import attrgetter
from pathlib import Path
from typing import Any

import pytest
import yaml
from rig.firmware import SHARED, Small

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


SCRIPTS = yaml.safe_load(Path(__file__).with_name("chips.yaml").read_text("utf-8"))
EACH = [(kind, title) for kind, scripts in SCRIPTS.items() for title in scripts]


class Orders:
    """What the orders of a script mean; each takes its words."""

    def __init__(self, kind: str) -> None:
        self._bench: Any = Bench(kind)
        self._chip: Any = self._bench.chip

    def sense(self, celsius: str) -> None:
        self._chip.sense(float(celsius))

    def wait(self, seconds: str) -> None:
        self._bench.run(float(seconds))

    def hold(self, ms: str) -> None:
        """Read an answer, and keep the chip selected."""
        self._bench.word(hold_ms=int(ms))

    def set(self, member: str, value: str) -> None:
        """Set what the chip is told by the test: a fault, a wire, its own temperature."""
        owner, _, name = member.rpartition(".")
        target = attrgetter(owner)(self._chip) if owner else self._chip
        assert hasattr(target, name)
        setattr(target, name, yaml.safe_load(value))

    def do(self, method: str, *values: str) -> None:
        getattr(self._chip, method)(*map(yaml.safe_load, values))

    def drive(self, pin: str, level: str) -> None:
        self._bench.reader.avr.pins.drive(pin, yaml.safe_load(level))

    def reads(self, celsius: str, within: str = "0") -> None:
        assert self._bench.celsius() == pytest.approx(float(celsius), rel=0, abs=float(within))

    def junction(self, celsius: str) -> None:
        assert self._bench.junction() == float(celsius)

    def bits(self, *words: str) -> None:
        """Compare the bits under a mask: of the answer, or of a register."""
        *register, mask, value = words
        found = self._bench.read(*register, 1)[0] if register else self._bench.word()
        assert found & int(mask, 16) == int(value, 16)

    def idles(self, level: str) -> None:
        assert bool(self._bench.reader["request.idle_high"]) == (level == "high")

    def write(self, register: str, *values: str) -> None:
        self._bench.write(register, *(int(value, 16) for value in values))

    def has(self, register: str, *values: str) -> None:
        """Compare registers from this one on."""
        due = POWER_ON if values == ("POWER_ON",) else bytes.fromhex("".join(values))
        assert self._bench.read(register, len(due)) == due

    def begin(self, cr0: str) -> None:
        self._bench.begin(cr0=int(cr0, 16))

    def is_(self, member: str, number: str) -> None:
        assert attrgetter(member)(self._chip) == int(number)


@pytest.mark.parametrize(("kind", "title"), EACH)
def test_it_does(kind: str, title: str) -> None:
    orders = Orders(kind)
    for step in SCRIPTS[kind][title].split(";"):
        order, *words = step.split()
        getattr(orders, "is_" if order == "is" else order)(*words)
