"""Whether settings survive what an EEPROM goes through; each check says what is wrong, if any."""

import struct
from collections.abc import Iterator
from itertools import product
from random import Random

import numpy as np
from host_ring import BLANK, Ring, Stored

from heatwright.sim.host import Host
from heatwright.spec import Controller
from heatwright.spec.algorithms import Algorithm

SETTINGS_CORRUPT = 16
DELAY_TICKS = 1000
LONG_TICKS = 66_000
"""More than sixteen bits count."""
GAINS = ("kp", "ki", "kd")
OLD_GAINS, NEW_GAINS = (2.0, 0.25, 8.5), (1e6, 0.0, 3.125)
OLD = Stored(9, 21.5, 12345, 35.0)
NEW = Stored(6, 86.25, 0, 40.5)
TORN = (-1, BLANK, 0x00, 0x5A)
"""What an interrupted write leaves in its byte: the old value, an erased cell, anything."""


class Storage:
    """A host build whose power can be taken away while it writes."""

    def __init__(self, host: Host) -> None:
        self.host = host
        self.ring = Ring(host.build)
        ((self._name, loop),) = host.build.controller.loops.items()
        by_host = self.ring.keeps_gains
        parts = host.build.parts
        self._hosted = parts.commanded and not parts.switched
        self._last_code = _last_code(host.build.controller)
        self.old, self.new = (
            each._replace(gains=gains if by_host else ())
            for each, gains in ((OLD, OLD_GAINS), (NEW, NEW_GAINS))
        )
        self.default = Stored(
            setpoint_c=loop.setpoint.initial_c,
            gains=_spec_gains(loop.algorithm) if by_host else (),
        )

    def boot(self, image: bytes | None = None) -> Stored:
        """Power up, with another EEPROM if given, and return what was restored."""
        if image is not None:
            self.host.eeprom[:] = image
        self.host.world.writes_left = self.host.world.torn = -1
        self.host.power_up()
        return self.now()

    def now(self) -> Stored:
        fault, settings = self.host.library.fault, self.host.library.settings
        setpoint_c = getattr(settings, f"{self._name}_setpoint_c")
        gains = self.gains_now() if self.ring.keeps_gains else ()
        return Stored(fault.code, fault.temperature_c, fault.time_s, setpoint_c, gains)

    def gains_now(self) -> tuple[float, ...]:
        settings = self.host.library.settings
        return tuple(getattr(settings, f"{self._name}_{each}") for each in GAINS)

    def set_gains(self, gains: tuple[float, ...]) -> None:
        for each, gain in zip(GAINS, gains, strict=True):
            setattr(self.host.library.settings, f"{self._name}_{each}", gain)

    def save(self, stored: Stored, writes_left: int = -1, torn: int = -1) -> None:
        """Change what is stored and save it; the power fails after so many bytes."""
        library, world = self.host.library, self.host.world
        library.fault.code, library.fault.temperature_c = stored.code, stored.temperature_c
        library.fault.time_s = stored.time_s
        setattr(library.settings, f"{self._name}_setpoint_c", stored.setpoint_c)
        if stored.gains:
            self.set_gains(stored.gains)
            library.settings_keep()
        library.settings_save()
        world.writes_left, world.torn = writes_left, torn
        library.host_settle()

    def as_restored(self, stored: Stored) -> Stored:
        if self.ring.stores_setpoint:
            return stored
        return stored._replace(setpoint_c=self.default.setpoint_c)

    def full(self, newest: int, sequence: int) -> bytes:
        """A ring in use: every slot written, the newest at `newest` with `sequence`."""
        slots = self.ring.slots
        records = {}
        for age in range(slots):
            aged = (
                self.old if age == 0 else Stored(1 + age % 3, float(age), age, 10.0, self.new.gains)
            )
            records[(newest - age) % slots] = self.ring.record(sequence - age, aged)
        return self.ring.image(records)

    # ---- the checks ----

    def blank(self) -> Iterator[str]:
        if self.boot(bytes([BLANK]) * self.ring.bytes) != self.default:
            yield f"a blank EEPROM gives {self.now()}"
        if self._settled_writes():
            yield "something is written although nothing has changed"

    def _settled_writes(self) -> int:
        before = self.host.world.eeprom_writes
        self.host.library.host_settle()
        return int(self.host.world.eeprom_writes - before)

    def newest(self) -> Iterator[str]:
        """Slots and sequence numbers: the newest record is taken, also where its number wraps."""
        sequences = (0, 1, self.ring.slots // 2, 65535, 32767, 32768, 40000)
        for slot, sequence in product((0, 1, self.ring.slots - 1), sequences):
            found = self.boot(self.full(slot, sequence))
            if found != self.as_restored(self.old):
                yield f"newest in slot {slot}, sequence {sequence}: {found}"
            self.save(self.new)
            following = (slot + 1) % self.ring.slots
            wanted = self.ring.record(sequence + 1, self.new)
            if self.ring.at(bytes(self.host.eeprom), following) != wanted:
                yield f"saved after slot {slot}, sequence {sequence}, not as it should be"

    def cuts(self, slots: range, torn: tuple[int, ...] | range = TORN) -> Iterator[str]:
        """The power fails at any byte of a save into any slot: the old or the new is there."""
        allowed = {self.as_restored(self.old), self.as_restored(self.new)}
        for slot in slots:
            image = self.full(slot, 65535 - slot)
            for written, left in product(range(self.ring.size + 1), torn):
                self.boot(image)
                self.save(self.new, written, left)
                found = self.boot()
                if found not in allowed or (
                    written == self.ring.size and found != self.as_restored(self.new)
                ):
                    yield f"cut after {written} bytes in slot {slot + 1}, {left} torn: {found}"

    def first_cuts(self) -> Iterator[str]:
        """The very first save is cut short, twice: the defaults, and no fault."""
        for written, left in product(range(self.ring.size), TORN):
            self.boot(bytes([BLANK]) * self.ring.bytes)
            for _ in range(2):
                self.save(self.new, written, left)
                found = self.boot()
                if found not in (self.default, self.as_restored(self.new)):
                    yield f"first save cut after {written} bytes, {left} torn: {found}"
            self.save(self.new)
            if self.boot() != self.as_restored(self.new):
                yield f"nothing can be saved after a first save cut after {written} bytes"

    def damaged(self, seed: int) -> Iterator[str]:
        """Some records are damaged: the newest of the others counts; if none is left, a fault."""
        random = Random(seed)  # noqa: S311
        ring, newest = self.ring, random.randrange(self.ring.slots)
        sequence = random.randrange(65536)
        image = bytearray(self.full(newest, sequence))
        spared = random.choice((0, 0, 1, 3, ring.slots))
        kept = set(random.sample(range(ring.slots), spared))
        for slot in set(range(ring.slots)) - kept:
            image[slot * ring.stride + random.randrange(ring.size)] ^= random.randrange(1, 256)
        found = self.boot(bytes(image))
        ages = {age: (newest - age) % ring.slots for age in range(ring.slots)}
        valid = [slot for slot in ages.values() if ring.is_valid(ring.at(bytes(image), slot))]
        if not valid:
            wanted = self.default._replace(code=SETTINGS_CORRUPT)
        else:
            code, _, temperature_c, time_s = struct.unpack_from(
                "<BBfI", ring.at(bytes(image), valid[0]), 9
            )
            wanted = Stored(code, temperature_c, time_s, *found[3:])  # judged by themselves
        if found != wanted:
            yield f"seed {seed}: {found}, not {wanted}"

    def noise(self, seed: int) -> Iterator[str]:
        """Any bytes at all: nothing is read or written outside, and a fault is latched."""
        self.boot(Random(seed).randbytes(self.ring.bytes))  # noqa: S311
        self.host.library.host_settle()
        if self.now().code != SETTINGS_CORRUPT:
            yield f"noise {seed} gives {self.now()}"

    def few_damaged(self) -> Iterator[str]:
        """One damaged record may be a first one cut short, two are not."""
        for damaged, code in ((1, 0), (2, SETTINGS_CORRUPT)):
            image = self.ring.image(dict.fromkeys(range(damaged), b"\x12" * self.ring.size))
            if self.boot(image) != self.default._replace(code=code):
                yield f"{damaged} damaged records give {self.now()}"

    def codes(self) -> Iterator[str]:
        """A fault of another firmware is a fault, and acknowledgements begin anew."""
        for code in (0, 1, self._last_code, self._last_code + 1, 255):
            self.boot(self.ring.image({3: self.ring.record(7, self.old._replace(code=code), 200)}))
            wanted = code if code <= self._last_code else SETTINGS_CORRUPT
            if self.now().code != wanted or self.host.library.fault.acknowledgements:
                yield f"code {code} is restored as {self.now()}"

    def setpoints(self) -> Iterator[str]:
        """A stored setpoint counts only where the operator may go."""
        if not self.ring.stores_setpoint:
            return
        setpoint = self.ring.loop.setpoint
        low, high = setpoint.minimum_c, setpoint.maximum_c
        beyond = (low - 0.01, high + 0.01, float("nan"), float("inf"), -1e30)
        for value in (low, high, 0.0, *beyond):
            record = self.ring.record(1, self.old._replace(setpoint_c=value))
            self.boot(self.ring.image({0: record}))
            off = value == 0 and self._hosted
            wanted = value if off or low <= value <= high else setpoint.initial_c
            if self.now().setpoint_c != wanted:
                yield f"setpoint {value} is restored as {self.now().setpoint_c}"

    def foreign(self) -> Iterator[str]:
        """Sound records of another specification count for nothing, whatever their size."""
        others = ((self.ring.digest + 0x10000) & 0xFFFFFFFF, self.ring.digest - 1)
        for size, digest in product((self.ring.size, 19, 23, 35, 64), others):
            image = bytearray([BLANK]) * self.ring.bytes
            for slot in range(self.ring.slots):
                record = self.ring.foreign(slot, size, digest)
                image[slot * self.ring.stride : slot * self.ring.stride + size] = record
            if self.boot(bytes(image)) != self.default:
                yield f"another firmware's records of {size} bytes give {self.now()}"
            self.save(self.new)
            if self.boot() != self.as_restored(self.new):
                yield f"nothing is kept among another firmware's records of {size} bytes"

    def other_layout(self) -> Iterator[str]:
        """A record of this specification, of another size, is of another version: not ours."""
        record = self.ring.record(1, self.old)
        for body in (record[3:] + b"\x00", record[3:-1]):
            checked = bytes([2 + len(body) - 1]) + body
            other = struct.pack("<H", self.ring.crc(checked)) + checked
            if self.boot(self.ring.image({0: other, 1: other})) != self.default:
                yield f"a record of {len(other)} bytes gives {self.now()}"

    def oversized(self) -> Iterator[str]:
        """A size by which a record ends one byte behind its slot is damage, whatever is there."""
        body = bytes([self.ring.stride - 1]) + bytes(self.ring.stride - 3)
        for behind in range(256):
            record = struct.pack("<H", self.ring.crc(body + bytes([behind]))) + body
            if self.boot(self.ring.image({0: record, 1: record})).code != SETTINGS_CORRUPT:
                yield f"records that go on behind their slots with {behind} give {self.now()}"

    def later(self) -> Iterator[str]:
        """A setpoint is saved when it has rested for 10 s."""
        if not self.ring.stores_setpoint:
            return
        library, world = self.host.library, self.host.world
        self.boot(bytes([BLANK]) * self.ring.bytes)
        for rest in (500, DELAY_TICKS, DELAY_TICKS + 1):
            library.settings_save_later()
            before = world.eeprom_writes
            for _ in range(rest):
                library.settings_tick()
            if (world.eeprom_writes != before) != (rest > DELAY_TICKS):
                yield f"after {rest} ticks {world.eeprom_writes - before} bytes are written"
        library.host_settle()
        before = world.eeprom_writes
        for _ in range(LONG_TICKS):
            library.settings_tick()
        if world.eeprom_writes != before:
            yield "it saves again, long after"

    def wear(self) -> Iterator[str]:
        """Every cell is written once in a turn of the ring, one byte a tick."""
        self.boot(bytes([BLANK]) * self.ring.bytes)
        for number in range(self.ring.slots):
            before = self.host.world.eeprom_writes
            self.save(self.old._replace(time_s=number))
            if self.host.world.eeprom_writes - before != self.ring.size:
                yield f"save {number} writes {self.host.world.eeprom_writes - before} bytes"
        image = bytes(self.host.eeprom)
        for slot in range(self.ring.slots):
            if not self.ring.is_valid(self.ring.at(image, slot)):
                yield f"slot {slot} was left out"

    def late_change(self) -> Iterator[str]:
        """What changes while a record is written comes into the next one."""
        self.boot(bytes([BLANK]) * self.ring.bytes)
        library = self.host.library
        library.fault.code = self.old.code
        library.settings_save()
        before = self.host.world.eeprom_writes
        for _ in range(5):
            library.settings_tick()
        self.save(self.new)
        if self.host.world.eeprom_writes - before != 2 * self.ring.size:
            yield "a record is not finished before the next one"
        if self.boot() != self.as_restored(self.new):
            yield f"a change while writing is lost: {self.now()}"

    def latch(self) -> Iterator[str]:
        """The first fault stays, also without power; acknowledged, it is gone for good."""
        library = self.host.library
        self.boot(bytes([BLANK]) * self.ring.bytes)
        library.fault_trip(self.old.code, self.old.temperature_c)
        library.fault_trip(self.new.code, self.new.temperature_c)
        library.host_settle()
        if self.boot()[:2] != self.old[:2]:
            yield f"after a loss of power the fault is {self.now()}"
        library.fault_acknowledge()
        library.fault_acknowledge()
        if library.fault.acknowledgements != 1:
            yield "an acknowledgement of nothing counts"
        library.host_settle()
        if self.boot().code:
            yield f"an acknowledged fault is back: {self.now()}"

    def outside(self) -> Iterator[str]:
        if self.host.world.eeprom_outside:
            yield f"{self.host.world.eeprom_outside} accesses outside the EEPROM"


def _last_code(controller: Controller) -> int:
    """Return the last fault that a controller can have, by docs/control.md."""
    kinds = {each.kind for each in controller.interfaces}
    last = {
        16: True,
        18: any(sensor.kind != "ds18b20" for sensor in controller.sensors.values()),
        19: "gcode" in kinds,
        22: len(controller.thermometers) < len(controller.sensors),
        23: "modbus_rtu" in kinds,
        24: bool(controller.programs),
        26: bool(controller.safety.relay_feedback),
    }
    return max(code for code, there in last.items() if there)


def _spec_gains(algorithm: Algorithm) -> tuple[float, ...]:
    return tuple(float(np.float32(getattr(algorithm, each, 0.0))) for each in GAINS)


def storage_problem(host: Host) -> str:
    """Run every check once, in a shorter form; say the first few things that are wrong."""
    storage = Storage(host)
    checks = [
        storage.blank(), storage.newest(), storage.cuts(range(1, storage.ring.slots, 36)),
        storage.first_cuts(), storage.few_damaged(), storage.codes(), storage.setpoints(),
        storage.foreign(), storage.other_layout(), storage.oversized(), storage.later(),
        storage.wear(), storage.late_change(), storage.latch(),
        *(storage.damaged(seed) for seed in range(12)), storage.noise(1), storage.outside(),
    ]  # fmt: skip
    for check in checks:
        for problem in check:
            return problem
    return ""
