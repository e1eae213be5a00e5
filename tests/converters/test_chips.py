"""The converters against their data sheets: chips.yaml, by way of a plain reader."""

from operator import attrgetter
from pathlib import Path
from typing import Any

import pytest
import yaml
from chip_bench import POWER_ON, Bench

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
        self._bench.reader.avr.pins.drive(pin, level)

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

    def misused(self, times: str) -> None:
        assert self._chip.misused == int(times)


@pytest.mark.parametrize(("kind", "title"), EACH)
def test_it_does(kind: str, title: str) -> None:
    orders = Orders(kind)
    for step in SCRIPTS[kind][title].split(";"):
        order, *words = step.split()
        getattr(orders, order)(*words)
