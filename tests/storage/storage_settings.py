"""Whether settings survive: the fault, a setpoint, gains, a lowered maximum, a chosen type."""

import struct
from collections.abc import Callable, Iterator
from itertools import product
from math import inf, nan

import numpy as np
from host_values import doubtful_limits
from storage_format import SETTINGS_STRIDE, TYPES, Settings, crc16
from storage_host import Kept

from heatwright.sim.host import Host
from heatwright.sim.reference.algorithms.pid import limits_of, may_limit
from heatwright.spec import Pid, facts_of
from heatwright.spec.sensing.max31856 import lowered

REST_TICKS = 1000  # a setting is saved when it has rested 10 s
CORRUPT = 16
GAIN_MAXIMUM = 1e6
GAINS = ("kp", "ki", "kd")
LIMITS = ("integral_minimum_percent", "integral_maximum_percent", "output_maximum_percent")


class SettingsKept(Kept):
    """Settings of any loop: what its specification has of all that may be kept."""

    checks = (
        "blank", "types", "gains", "limits", "latch", "codes", "damaged_first", "restored", "noise",
        "damaged", "foreign", "behind", "twins", "sizes", "newest", "later", "lasting", "meanwhile",
        "cuts", "first_cuts", "torn", "beyond", "flipped",
    )  # fmt: skip
    turns = (0, 1, 255, 32767, 32768, 65535)

    def __init__(self, host: Host, *, short: bool = False) -> None:
        super().__init__(host, short=short)
        memory, self._loop = self.memory, self.parts.name
        self.slot_bytes = memory.settings_slot
        loop, sensor = self.controller.loops[self._loop], self.controller.sensors[self.parts.sensor]
        self.slots, self.size = memory.settings_slots, memory.settings_bytes
        self.codes_allowed = {TYPES.index(each) for each in getattr(sensor, "selectable", ())}
        own = TYPES.index(sensor.thermocouple) if memory.has_type else None  # type: ignore[attr-defined]
        self._setpoint = setpoint = loop.setpoint
        initial_c, highest_c = setpoint.initial_c, loop.protection.maximum_c
        default = tuple(float(np.float32(getattr(loop.algorithm, each, 0.0))) for each in GAINS)
        gains = (default, (2.0, 0.25, 8.75), (GAIN_MAXIMUM, 0.0, 3.125))
        if not memory.has_gains:
            gains = ((), (), ())
        setpoints_c = (initial_c, 35.0, 40.5) if memory.has_setpoint else (initial_c,) * 3
        self.low_c, self._kind = setpoint.maximum_c + 5.0, f"{self.parts.sensor}_thermocouple"
        less = lowered(sensor, setpoint.maximum_c, highest_c)
        above_k = highest_c - setpoint.maximum_c
        self._hottest_c = {
            TYPES.index(each): float(np.float32(less[each] + above_k)) for each in less
        }
        other = next(iter(self.codes_allowed - {own}), None)
        low_c = min(self.low_c, self._hottest_c.get(other, self.low_c))
        maxima_c: tuple[float | None, ...] = (highest_c, low_c, setpoint.minimum_c)
        if not memory.has_maximum:
            maxima_c = (None, None, None)
        limits: tuple[tuple[float, ...], ...] = ((), (), ())
        if memory.has_limits:
            least, most, full = (float(each) for each in limits_of(loop.algorithm))
            limits = (least, most, full), (least + 1.5, most - 2, full - 5), (least, least, 60.5)
        ends = [(each.value, each.minimum, each.maximum) for each in memory.numbers]
        numbers = [tuple(float(np.float32(each[way])) for each in ends) for way in range(3)]
        self.default, self.old, self.new = (
            Settings(*fault, *values)
            for fault, *values in zip(
                ((0, 0.0, 0), (9, 21.5, 12345), (6, 86.25, 0)),
                setpoints_c, gains, maxima_c, (own, other, own), limits, numbers, strict=True,
            )
        )  # fmt: skip

    def save(self, value: Settings) -> None:
        fault = self.library.fault
        fault.code, fault.temperature_c, fault.time_s = value[:3]
        self._put("setpoint_c", value.setpoint_c)
        if value.gains:
            self.set_gains(value.gains)
            self.set_limits(value.limits)
            self.library.settings_keep()
        self._choose(value)
        self.library.settings_save()

    def _choose(self, kept: Settings) -> None:
        if kept.maximum_c is not None:
            assert getattr(self.library, f"guard_{self._loop}_set_maximum")(kept.maximum_c)
        if kept.type is not None:
            assert self._set_type(kept.type)
        for each, value in zip(self.memory.numbers, kept.numbers, strict=True):
            self._put(each.kind.field, value)

    def _set_type(self, code: int) -> bool:
        return bool(getattr(self.library, f"settings_set_{self._kind}")(code))

    def _put(self, name: str, value: float) -> None:
        setattr(self.library.settings, f"{self._loop}_{name}", value)

    def _get(self, name: str) -> float:
        return float(getattr(self.library.settings, f"{self._loop}_{name}"))

    def set_gains(self, gains: tuple[float, ...]) -> None:
        for name, gain in zip(GAINS, gains, strict=True):
            self._put(name, gain)

    def set_limits(self, limits: tuple[float, ...]) -> None:
        for name, limit in zip(LIMITS, limits, strict=False):
            self._put(name, limit)

    def limits_now(self) -> tuple[float, ...]:
        return tuple(self._get(each) for each in LIMITS) if self.memory.has_limits else ()

    def gains_now(self) -> tuple[float, ...]:
        return tuple(self._get(each) for each in GAINS) if self.memory.has_gains else ()

    def found(self) -> Settings:
        fault, settings = self.library.fault, self.library.settings
        maximum_c = getattr(settings, f"{self._loop}_maximum_c", None)
        kind = getattr(settings, self._kind, None)
        numbers = tuple(self._get(each.kind.field) for each in self.memory.numbers)
        others = self._get("setpoint_c"), self.gains_now(), maximum_c, kind, self.limits_now()
        return Settings(fault.code, fault.temperature_c, fault.time_s, *others, numbers)

    def known(self, image: bytes) -> Settings:
        """The newest; where none is sound a fault, unless it is the first that was cut short."""
        newest = self.memory.settings(image)
        written = sum(image[slot * SETTINGS_STRIDE + 2] != 0xFF for slot in range(self.slots))
        return newest or self.default._replace(code=CORRUPT if written > 1 else 0)

    def slot_at(self, slot: int) -> int:
        return slot * SETTINGS_STRIDE

    def used(self, slot: int, turn: int) -> bytes:
        aged = (self.old._replace(code=1 + age % 5, time_s=age) for age in range(1, self.slots))
        return self.in_ring(slot, turn, (self.old, *aged))

    def boot_with(self, kept: Settings, seen: int = 0) -> None:
        self.boot(self.memory.image((self.slot_at(3), self.slot_bytes(7, kept, None, seen))))

    def blank(self) -> Iterator[str]:
        """What the spec says, and nothing is written."""
        self.boot(self.memory.blank)
        yield from self.expect("blank", self.default)
        before = self.host.world.eeprom_writes
        for _ in range(70_000):  # more than a count of 16 bit, which may not begin anew
            self.library.settings_tick()
        if self.host.world.eeprom_writes != before:
            yield "something is written although nothing has changed"

    def flipped(self) -> Iterator[str]:
        """A flipped bit of what is sealed is found, and what was stored comes back, the rest as the
        spec has it."""
        library, loop = self.library, self._loop
        for stored in (None, self.old, self.new):
            bits = range(32) if stored is self.old else (0,)
            for name, bit in product((f"{loop}_setpoint_c", f"{loop}_maximum_c", self._kind), bits):
                if not hasattr(library.settings, name) or (name == self._kind and bit > 7):
                    continue
                if stored is None:
                    self.boot(self.memory.blank)
                else:
                    self.boot_with(stored)
                raw = self.ffi.buffer(self.ffi.addressof(library.settings, name))
                raw[bit // 8] = bytes([raw[bit // 8][0] ^ 1 << bit % 8])
                if library.settings_are_sound():
                    yield f"{name} has changed, and nobody says so"
                yield from self.expect(f"{name} is flipped", stored or self.default)
                if not library.settings_are_sound():
                    yield f"{name} is not sealed again"

    def later(self) -> Iterator[str]:
        """What an operator chooses is saved by itself when it has rested, and once."""
        default, memory = self.default, self.memory
        kinds = self.codes_allowed - {default.type}
        hottest_c = {each: self._hottest_c.get(each, default.maximum_c) for each in kinds}
        chosen = [default._replace(type=each, maximum_c=hottest_c[each]) for each in kinds]
        chosen += [default._replace(maximum_c=self.low_c)] * memory.has_maximum
        chosen += [default._replace(setpoint_c=40.5)] * memory.has_setpoint
        chosen += [default._replace(numbers=self.new.numbers)] * bool(memory.numbers)
        for kept in chosen:
            self.boot(memory.blank)
            self._put("setpoint_c", kept.setpoint_c)
            self._choose(kept)
            if kept[3:4] + kept[7:] != default[3:4] + default[7:]:  # whoever sets it says so
                self.library.settings_save_later()
            if self.tick(REST_TICKS):
                yield "it is written at once"
            if self.tick(self.size) != self.size:
                yield "it is not written after 10 s"
            self._choose(kept)
            if self.tick(2 * REST_TICKS):
                yield "what has not changed is written"
            self.boot()
            yield from self.expect("after a loss of power", kept)

    def lasting(self) -> Iterator[str]:
        """A commanded loop comes back with the setpoint it held; one that 0 switches off comes
        back off if it was, or did something else."""
        if not (self.memory.has_setpoint and self.parts.commanded):
            return
        library = self.library
        ways: dict[str, tuple[Callable[[], object], float]] = {
            "higher": (lambda: library.loop_air_set(50.0), 50.0),
            "lower": (lambda: library.loop_air_set(40.0), 40.0),
        }
        if not self.parts.switched:
            ways["off"] = (lambda: library.loop_air_set(0.0), 0.0)
            ways["acknowledged"] = (self._trip_and_acknowledge, 0.0)
            if self.parts.autotune:
                ways["tuning"] = (lambda: library.loop_air_tune(50.0, 5), 0.0)
            if self.parts.tunable:
                ways["by hand"] = (lambda: library.loop_air_set_manual(30.0), 0.0)
        for name, (way, wanted_c) in ways.items():
            self.boot(self.memory.blank)
            library.loop_air_set(45.0)
            self.tick(REST_TICKS + self.size)
            way()
            self.tick(2 * self.size + (name != "off") * REST_TICKS)  # off is kept at once
            self.boot()
            if self._get("setpoint_c") != wanted_c:
                yield f"{name}: it comes back as {self._get('setpoint_c')}, not {wanted_c}"
            if self.parts.switched and library.loop_air_set(wanted_c) and self.tick(2 * REST_TICKS):
                yield "the same setpoint wears the EEPROM out"

    def _trip_and_acknowledge(self) -> None:
        self.library.fault_trip(self.old.code, self.old.temperature_c)
        self.library.host_acknowledge()

    def meanwhile(self) -> Iterator[str]:
        """What changes while a record is written comes into the next one."""
        self.boot(self.memory.blank)
        self.save(self.old)
        self.tick(5)
        self.save(self.new)
        if self.settle() != 2 * self.size - 4:
            yield "a record is not finished before the next one"
        self.boot()
        yield from self.expect("changed while it was written", self.new)

    def latch(self) -> Iterator[str]:
        """The first fault stays, also without power, and keeps no gains that were only set;
        acknowledged, it is gone for good."""
        self.boot(self.memory.blank)
        if self.memory.has_gains:
            self.set_gains(self.new.gains)
        for kept in (self.old, self.new):
            self.library.fault_trip(kept.code, kept.temperature_c)
        self.settle()
        self.boot()
        latched = self.default._replace(code=self.old.code, temperature_c=self.old.temperature_c)
        yield from self.expect("latched", latched)
        self.library.host_acknowledge()
        self.library.host_acknowledge()
        if self.library.fault.acknowledgements != 1:
            yield "an acknowledgement of nothing counts"
        self.settle()
        self.boot()
        if self.found().code:
            yield f"an acknowledged fault is back: {self.found()}"

    def types(self) -> Iterator[str]:
        """Only the types that the spec allows are taken."""
        self.boot(self.memory.blank)
        for code in range(256) if self.memory.has_type else ():
            before = self.found().type
            taken = self._set_type(code)
            if taken != (code in self.codes_allowed):
                yield f"type {code} is {'' if taken else 'not '}taken"
            if self.found().type != (code if taken else before):
                yield f"type {code} makes it {self.found().type}"

    def gains(self) -> Iterator[str]:
        """They are kept when told, and once; what is kept, and what the spec has, comes back."""
        self.boot(self.memory.blank)
        for each in range(3 * self.memory.has_gains):
            changed = [*self.default.gains]
            changed[each] = float(np.float32(changed[each] + 1.5))
            self.set_gains(tuple(changed))
            if self.settle():
                yield "gains are kept that nobody has told to keep"
            self.library.settings_reload()
            if self.gains_now() != self.default.gains:
                yield "what is kept does not come back"
            for wanted in (self.size, 0):
                self.set_gains(tuple(changed))
                self.library.settings_keep()
                self.library.settings_reload()
                if self.gains_now() != tuple(changed):
                    yield "what is kept and not yet written does not come back"
                if self.settle() != wanted:
                    yield f"gain {each} is written {'not' if wanted else 'though nothing changed'}"
            self.library.settings_defaults()
            if self.gains_now() != self.default.gains:
                yield "what the spec has does not come back"
            self.library.settings_keep()
            if self.settle() != self.size:
                yield f"gain {each} is not kept where it is less than before"

    def limits(self) -> Iterator[str]:
        """They are kept with the gains, when told and once, and come back with them."""
        if not self.memory.has_limits:
            return
        self.boot(self.memory.blank)
        for changed in (self.old.limits, self.new.limits):
            ways = {"settings_reload": self.limits_now(), "settings_keep": changed}
            for way, wanted in ways.items():
                self.set_limits(changed)
                getattr(self.library, way)()
                if self.limits_now() != wanted:
                    yield f"{way} makes the limits {self.limits_now()}, not {wanted}"
            if (self.settle(), self.settle()) != (self.size, 0):
                yield "limits are not written, or more than once"
            for each, other in product(range(3), (1.5, -3.0, 0.0)):
                moved = [*self.limits_now()]
                moved[each] += other
                self.set_limits(tuple(moved))
                self.library.settings_keep()
                if self.settle() != (self.size if other else 0):
                    yield f"limit {each} is written {'not' if other else 'though nothing changed'}"
        self.library.settings_defaults()
        if self.limits_now() != self.default.limits:
            yield "what the spec has does not come back"

    def _limits_of_a_record(self) -> Iterator[str]:
        """Limits are taken all together, or none of them."""
        algorithm = self.controller.loops[self._loop].algorithm
        assert isinstance(algorithm, Pid)
        for limits in doubtful_limits(algorithm):
            kept = self.old._replace(limits=tuple(map(float, limits)))
            self.boot_with(kept)
            taken = may_limit(algorithm, limits)
            wanted = kept if taken else kept._replace(limits=self.default.limits)
            yield from self.expect(f"limits of {limits}", wanted)

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
        last = max(rule.code for rule in facts_of(self.controller).rules)
        for code in (0, 1, last, last + 1, 255):
            kept = self.old._replace(code=code)
            self.boot_with(kept, seen=200)
            known = code if code <= last else CORRUPT
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
        setpoint, places = self._setpoint, 3 * self.memory.has_gains
        low, high = setpoint.minimum_c, setpoint.maximum_c
        beyond = (low - 0.01, high + 0.01, nan, inf, -1e30)
        for setpoint_c in (low, high, 0.0, *beyond) if self.memory.has_setpoint else ():
            kept = self.old._replace(setpoint_c=setpoint_c)
            self.boot_with(kept)
            off = setpoint_c == 0 and self.parts.commanded and not self.parts.switched
            taken = off or low <= setpoint_c <= high
            wanted = kept._replace(setpoint_c=setpoint_c if taken else setpoint.initial_c)
            yield from self.expect(f"setpoint {setpoint_c}", wanted)
        tried = (-1e-30, GAIN_MAXIMUM + 0.1, inf, nan, 0.0, GAIN_MAXIMUM)
        for each, gain in product(range(places), tried):
            changed = [*self.old.gains]
            changed[each] = gain
            kept = self.old._replace(gains=tuple(changed))
            self.boot_with(kept)
            gains = kept.gains if 0 <= gain <= GAIN_MAXIMUM else self.default.gains
            yield from self.expect(f"gain {each} of {gain}", kept._replace(gains=gains))
        for place, each in enumerate(self.memory.numbers):
            least, most = float(np.float32(each.minimum)), float(np.float32(each.maximum))
            beyond = (least - 0.01, most + 0.01, nan, inf, -inf)
            for value in (least, most, *beyond):
                changed = [*self.old.numbers]
                changed[place] = float(np.float32(value))
                kept = self.old._replace(numbers=tuple(changed))
                self.boot_with(kept)
                if value in beyond:
                    changed[place] = self.default.numbers[place]
                wanted = kept._replace(numbers=tuple(changed))
                yield from self.expect(f"{each.kind.key} of {value}", wanted)
        if self.memory.has_limits:
            yield from self._limits_of_a_record()
        if not self.memory.has_maximum:
            return
        high = self.default.maximum_c
        assert high is not None
        temperatures = {low: True, high - 0.5: True, high: True, nan: False, inf: False}
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
