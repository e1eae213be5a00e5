"""Whether settings survive: the fault, gains, a lowered maximum, a chosen type of thermocouple."""

import struct
from collections.abc import Iterator
from itertools import product

import numpy as np
from storage_format import SETTINGS_STRIDE, TYPES, Settings, crc16
from storage_host import Kept

from heatwright.sim.host import HostBuild

REST_TICKS = 1000
"""A setting is saved when it has rested 10 s."""
CORRUPT, LAST_CODE = 16, 24
GAIN_MAXIMUM = 1e6


class SettingsKept(Kept):
    """The loop's maximum may be lowered; the type of its thermocouple may be chosen, or not."""

    checks = (
        "blank", "types", "gains", "codes", "damaged_first", "restored", "noise", "damaged",
        "foreign", "behind", "twins", "sizes", "newest", "later", "cuts", "first_cuts", "torn",
        "beyond",
    )  # fmt: skip
    turns = (0, 1, 255, 32767, 32768, 65535)

    def __init__(self, build: HostBuild, *, short: bool = False) -> None:
        super().__init__(build, short=short)
        memory, loop = self.memory, self.controller.loops["chamber"]
        sensor = self.controller.sensors["chamber"]
        self.slots, self.size = memory.settings_slots, memory.settings_bytes
        self.codes_allowed = {TYPES.index(each) for each in getattr(sensor, "selectable", ())}
        own = TYPES.index(sensor.thermocouple) if memory.has_type else None  # type: ignore[attr-defined]
        pid = loop.algorithm
        gains = tuple(float(np.float32(each)) for each in (pid.kp, pid.ki, pid.kd))  # type: ignore[union-attr]
        self.lowest_c = loop.setpoint.minimum_c
        highest_c = loop.protection.maximum_c if memory.has_maximum else None
        self.default = Settings(0, 0.0, 0, gains, highest_c, own)
        other = next(iter(self.codes_allowed - {own}), None)
        low_c, lowest_c = (95.5, self.lowest_c) if memory.has_maximum else (None, None)
        self.old = Settings(9, 21.5, 12345, (2.0, 0.25, 8.5), low_c, other)
        self.new = Settings(6, 86.25, 0, (GAIN_MAXIMUM, 0.0, 3.125), lowest_c, own)

    def save(self, value: Settings) -> None:
        fault, settings = self.library.fault, self.library.settings
        fault.code, fault.temperature_c, fault.time_s = value[:3]
        self.set_gains(value.gains)
        self.library.settings_keep()
        if value.maximum_c is not None:
            assert self.library.guard_chamber_set_maximum(value.maximum_c)
        if value.type is not None:
            assert self.library.settings_set_chamber_thermocouple(value.type)
            assert settings.chamber_thermocouple == value.type
        self.library.settings_save()

    def set_gains(self, gains: tuple[float, ...]) -> None:
        for name, gain in zip(("kp", "ki", "kd"), gains, strict=True):
            setattr(self.library.settings, f"chamber_{name}", gain)

    def gains_now(self) -> tuple[float, ...]:
        return tuple(
            getattr(self.library.settings, f"chamber_{each}") for each in ("kp", "ki", "kd")
        )

    def found(self) -> Settings:
        fault, settings = self.library.fault, self.library.settings
        maximum_c = settings.chamber_maximum_c if self.memory.has_maximum else None
        kind = settings.chamber_thermocouple if self.memory.has_type else None
        return Settings(
            fault.code, fault.temperature_c, fault.time_s, self.gains_now(), maximum_c, kind
        )

    def known(self, image: bytes) -> Settings:
        """The newest; where none is sound a fault, unless it is the first that was cut short."""
        newest = self.memory.settings(image)
        written = sum(image[slot * SETTINGS_STRIDE + 2] != 0xFF for slot in range(self.slots))
        return newest or self.default._replace(code=CORRUPT if written > 1 else 0)

    def slot_at(self, slot: int) -> int:
        return slot * SETTINGS_STRIDE

    def slot_bytes(self, turn: int, value: Settings, digest: bytes | None = None) -> bytes:
        return self.memory.settings_slot(turn, value, digest)

    def used(self, slot: int, turn: int) -> bytes:
        pieces = []
        for age in range(self.slots):
            record = self.old if age == 0 else self.old._replace(code=1 + age % 5, time_s=age)
            pieces.append(
                (self.slot_at((slot - age) % self.slots), self.slot_bytes(turn - age, record))
            )
        return self.memory.image(*pieces)

    def boot_with(self, kept: Settings, seen: int = 0) -> None:
        self.boot(
            self.memory.image((self.slot_at(3), self.memory.settings_slot(7, kept, None, seen)))
        )

    # ---- the checks ----

    def blank(self) -> Iterator[str]:
        """What the spec says, and nothing is written."""
        self.boot(self.memory.blank)
        yield from self.expect("blank", self.default)
        setpoint = self.controller.loops["chamber"].setpoint
        if self.library.settings.chamber_setpoint_c != setpoint.initial_c:
            yield "the setpoint does not begin where it should"
        before = self.host.world.eeprom_writes
        for _ in range(70_000):  # more than a count of 16 bit, which may not begin anew
            self.library.settings_tick()
        if self.host.world.eeprom_writes != before:
            yield "something is written although nothing has changed"

    def later(self) -> Iterator[str]:
        """What an operator chooses is saved by itself when it has rested, and once."""
        lowered = self.default._replace(maximum_c=95.5)
        others = sorted(self.codes_allowed - {self.default.type}) or [None]
        kinds = (
            [self.default._replace(type=each) for each in others] if self.memory.has_type else []
        )
        for kept in (*kinds, lowered) if self.memory.has_maximum else ():
            self.boot(self.memory.blank)
            self._choose(kept)
            if self.tick(REST_TICKS):
                yield "it is written at once"
            if self.tick(self.size) != self.size:
                yield "it is not written after 10 s"
            self._choose(kept)
            if self.tick(2 * REST_TICKS):
                yield "what has not changed is written"
            self.boot()
            yield from self.expect("after a loss of power", kept)

    def _choose(self, kept: Settings) -> None:
        assert self.library.guard_chamber_set_maximum(kept.maximum_c)
        if kept.type is not None:
            assert self.library.settings_set_chamber_thermocouple(kept.type)

    def types(self) -> Iterator[str]:
        """Of all types only those that the spec allows."""
        self.boot(self.memory.blank)
        for code in range(256) if self.memory.has_type else ():
            before = self.found().type
            taken = bool(self.library.settings_set_chamber_thermocouple(code))
            if taken != (code in self.codes_allowed):
                yield f"type {code} is {'' if taken else 'not '}taken"
            if self.found().type != (code if taken else before):
                yield f"type {code} makes it {self.found().type}"

    def gains(self) -> Iterator[str]:
        """They are kept when told, and once; what is kept, and what the spec has, comes back."""
        self.boot(self.memory.blank)
        for each in range(3):
            changed = [*self.default.gains]
            changed[each] += 1.5
            self.set_gains(tuple(changed))
            if self.settle():
                yield "gains are kept that nobody has told to keep"
            self.library.settings_reload()
            if self.gains_now() != self.default.gains:
                yield "what is kept does not come back"
            for wanted in (self.size, 0):
                self.set_gains(tuple(changed))
                self.library.settings_keep()
                if self.settle() != wanted:
                    yield f"gain {each} is written {'not' if wanted else 'though nothing changed'}"
            self.library.settings_defaults()
            if self.gains_now() != self.default.gains:
                yield "what the spec has does not come back"
            self.library.settings_keep()
            if self.settle() != self.size:
                yield f"gain {each} is not kept where it is less than before"

    def sizes(self) -> Iterator[str]:
        """A sound record of another size is not ours; one too large for a slot is damaged."""
        most = SETTINGS_STRIDE - 2
        for size in (7, self.size - 3, self.size - 1, most - 1, most):
            body = bytes([size]) + self.memory.digest + bytes(size - 5)
            yield from self._twice(f"size {size}", struct.pack("<H", crc16(body)) + body, 0)
        for size, beyond in product((most + 1, most + 2), range(256)):
            body = bytes([size]) + bytes(most - 1)
            crc = crc16(body + bytes([beyond]) * (size - most))
            yield from self._twice(f"size {size}", struct.pack("<H", crc) + body, CORRUPT)

    def _twice(self, when: str, piece: bytes, code: int) -> Iterator[str]:
        self.boot(self.memory.image(*((self.slot_at(slot), piece) for slot in (0, 1))))
        yield from self.expect(when, self.default._replace(code=code))

    def codes(self) -> Iterator[str]:
        """A fault of another firmware is a fault, and acknowledgements begin anew."""
        for code in (0, 1, LAST_CODE, LAST_CODE + 1, 255):
            kept = self.old._replace(code=code)
            self.boot_with(kept, seen=200)
            known = code if code <= LAST_CODE else CORRUPT
            yield from self.expect(f"code {code}", kept._replace(code=known))
            if self.library.fault.acknowledgements:
                yield "acknowledgements go on"

    def damaged_first(self) -> Iterator[str]:
        """One damaged record may be a first one cut short, two are not."""
        for count in range(4):
            pieces = [(self.slot_at(slot), b"\x12" * self.size) for slot in range(count)]
            image = self.memory.image(*pieces)
            self.boot(image)
            yield from self.expect(f"{count} damaged", self.known(image))
            if bool(self.settle()) != (count > 1):
                yield f"{count} damaged: the fault is not kept, or none is"

    def restored(self) -> Iterator[str]:
        """A record is taken as far as it is possible, each value by itself."""
        inf, nan = float("inf"), float("nan")
        for each, gain in product(range(3), (-1e-6, GAIN_MAXIMUM + 1, inf, nan, 0.0, GAIN_MAXIMUM)):
            changed = [*self.old.gains]
            changed[each] = gain
            kept = self.old._replace(gains=tuple(changed))
            self.boot_with(kept)
            gains = kept.gains if 0 <= gain <= GAIN_MAXIMUM else self.default.gains
            yield from self.expect(f"gain {each} of {gain}", kept._replace(gains=gains))
        if not self.memory.has_maximum:
            return
        low, high = self.lowest_c, self.default.maximum_c
        assert high is not None
        temperatures = {low: True, high: True, 50.25: True, nan: False, inf: False}
        temperatures |= {low - 0.01: False, high + 0.01: False}
        codes = sorted({0, 3, 6, 7, 8, 9, 16, 19, 255} | self.codes_allowed)
        for maximum_c, code in product(temperatures, codes if self.memory.has_type else (None,)):
            kept = self.old._replace(maximum_c=maximum_c, type=code)
            self.boot_with(kept)
            wanted = kept._replace(
                maximum_c=maximum_c if temperatures[maximum_c] else high,
                type=code if code in self.codes_allowed else self.default.type,
            )
            yield from self.expect(f"a record of {maximum_c} and type {code}", wanted)
