"""Whether a lowered maximum and a chosen type of thermocouple survive, and none that is wrong."""

import struct
from collections.abc import Iterator
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from storage_format import crc16
from storage_host import TORN, StorageHost

REST_TICKS = 1000
"""A setting is saved when it has rested 10 s."""
STRIDE = 64
TYPES = "BEJKNRST"


class Kept(NamedTuple):
    maximum_c: float
    type: int


class Settings(StorageHost):
    """The loop's maximum may be lowered; the type of its thermocouple may be chosen, or not."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        sensor = self.controller.sensors["chamber"]
        loop = self.controller.loops["chamber"]
        selectable = getattr(sensor, "selectable", ())
        self.typed = bool(selectable)
        self.codes = {TYPES.index(each) for each in selectable}
        own = TYPES.index(sensor.thermocouple) if self.typed else 0  # type: ignore[attr-defined]
        self.default = Kept(loop.protection.maximum_c, own)
        self.lowest_c = loop.setpoint.minimum_c
        other = next(iter(self.codes - {own}), 0)
        self.old, self.new = Kept(95.5, other), Kept(self.lowest_c, own)
        pid: Any = loop.algorithm
        self._gains = tuple(np.float32([pid.kp, pid.ki, pid.kd]))

    def record(self, sequence: int, kept: Kept) -> bytes:
        values = struct.pack("<ffff", *self._gains, kept.maximum_c)
        values += bytes([kept.type]) * self.typed
        head = struct.pack("<4sHBBfI", self.memory.digest, sequence, 0, 0, 0.0, 0)
        body = bytes([1 + len(head) + len(values)]) + head + values
        return struct.pack("<H", crc16(body)) + body

    def with_record(self, kept: Kept) -> bytes:
        return self.memory.with_at(self.memory.blank, (0, self.record(1, kept)))

    def now(self) -> Kept:
        settings = self.library.settings
        kind = settings.chamber_thermocouple if self.typed else 0
        return Kept(settings.chamber_maximum_c, kind)

    def expect(self, when: str, *wanted: Kept) -> Iterator[str]:
        if self.now() not in wanted:
            yield f"{when}: {self.now()}, not {wanted}"

    def set(self, kept: Kept) -> None:
        assert self.library.guard_chamber_set_maximum(kept.maximum_c)
        if self.typed:
            assert self.library.settings_set_chamber_thermocouple(kept.type)

    # ---- the checks ----

    def blank(self) -> Iterator[str]:
        self.boot(self.memory.blank)
        yield from self.expect("blank", self.default)

    def later(self) -> Iterator[str]:
        """Each is saved by itself when it has rested, and once."""
        self.boot(self.memory.blank)
        mixed = [self.old._replace(maximum_c=self.default.maximum_c), self.old]
        for kept in mixed[0 if self.typed else 1 :]:
            self.set(kept)
            if self.tick(REST_TICKS - 1):
                yield "it is written at once"
            if self.tick(100) != len(self.record(1, kept)):
                yield "it is not written once after 10 s"
            self.set(kept)
            if self.tick(2 * REST_TICKS):
                yield "what has not changed is written"
            self.boot()
            yield from self.expect("after a loss of power", kept)

    def types(self) -> Iterator[str]:
        """Of all types only those that the spec allows."""
        if not self.typed:
            return
        self.boot(self.memory.blank)
        for code in range(256):
            before = self.now().type
            taken = bool(self.library.settings_set_chamber_thermocouple(code))
            if taken != (code in self.codes):
                yield f"type {code} is {'' if taken else 'not '}taken"
            if self.now().type != (code if taken else before):
                yield f"type {code} makes it {self.now().type}"

    def restored(self) -> Iterator[str]:
        """A record is taken as far as it is possible, each value by itself."""
        low, high = self.lowest_c, self.default.maximum_c
        temperatures = {low: True, high: True, 50.25: True, float("nan"): False}
        temperatures |= {low - 0.01: False, high + 0.01: False, float("inf"): False}
        codes = range(256) if self.typed else (0,)
        for maximum_c, code in product(temperatures, codes):
            if code not in {0, 3, 6, 7, 8, 9, 16, 19, 255} | self.codes:
                continue
            self.boot(self.with_record(Kept(maximum_c, code)))
            wanted = Kept(
                maximum_c if temperatures[maximum_c] else high,
                code if code in self.codes else self.default.type,
            )
            yield from self.expect(f"a record of {maximum_c} and type {code}", wanted)

    def cuts(self) -> Iterator[str]:
        """The power fails at any byte: the old or the new is there."""
        image = self.with_record(self.old)
        size = len(self.record(2, self.new))
        for written, left in product(range(size + 1), TORN):
            self.boot(image)
            yield from self.expect("stored", self.old)
            self.set(self.new)
            self.tick(REST_TICKS - 1)
            self.cut_after(written, left)
            self.settle()
            self.boot()
            wanted = (self.new,) if written == size else (self.old, self.new)
            yield from self.expect(f"cut after {written} bytes, {left} torn", *wanted)

    def beyond(self) -> Iterator[str]:
        if self.outside:
            yield f"{self.outside} accesses outside the EEPROM"


CHECKS = ("blank", "later", "types", "restored", "cuts", "beyond")


def settings_problem(checked: Settings) -> str:
    """Run every check; say the first thing that is wrong."""
    return next((problem for check in CHECKS for problem in getattr(checked, check)()), "")
