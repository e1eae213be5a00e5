"""Whether settings survive what an EEPROM goes through; each check says what is wrong, if any."""

import struct
from collections.abc import Iterator
from itertools import product
from random import Random

from host_ring import BLANK, Ring, Stored

from heatwright.sim.host import Host

SETTINGS_CORRUPT = 16
LAST_CODE = 16
DELAY_TICKS = 1000
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
        self._default = Stored(setpoint_c=loop.setpoint.initial_c)

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
        return Stored(fault.code, fault.temperature_c, fault.time_s, setpoint_c)

    def save(self, stored: Stored, writes_left: int = -1, torn: int = -1) -> None:
        """Change what is stored and save it; the power fails after so many bytes."""
        library, world = self.host.library, self.host.world
        library.fault.code, library.fault.temperature_c = stored.code, stored.temperature_c
        library.fault.time_s = stored.time_s
        setattr(library.settings, f"{self._name}_setpoint_c", stored.setpoint_c)
        library.settings_save()
        world.writes_left, world.torn = writes_left, torn
        library.host_settle()

    def as_restored(self, stored: Stored) -> Stored:
        if self.ring.stores_setpoint:
            return stored
        return stored._replace(setpoint_c=self._default.setpoint_c)

    def full(self, newest: int, sequence: int, stored: Stored = OLD) -> bytes:
        """A ring in use: every slot written, the newest at `newest` with `sequence`."""
        slots = self.ring.slots
        records = {}
        for age in range(slots):
            aged = stored if age == 0 else Stored(1 + age % 3, float(age), age, 10.0)
            records[(newest - age) % slots] = self.ring.record(sequence - age, aged)
        return self.ring.image(records)

    # ---- the checks ----

    def blank(self) -> Iterator[str]:
        if self.boot(bytes([BLANK]) * self.ring.bytes) != self._default:
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
            if found != self.as_restored(OLD):
                yield f"newest in slot {slot}, sequence {sequence}: {found}"
            self.save(NEW)
            following = (slot + 1) % self.ring.slots
            wanted = self.ring.record(sequence + 1, NEW)
            if self.ring.at(bytes(self.host.eeprom), following) != wanted:
                yield f"saved after slot {slot}, sequence {sequence}, not as it should be"

    def cuts(self, slots: range, torn: tuple[int, ...] | range = TORN) -> Iterator[str]:
        """The power fails at any byte of a save into any slot: the old or the new is there."""
        allowed = {self.as_restored(OLD), self.as_restored(NEW)}
        for slot in slots:
            image = self.full(slot, 65535 - slot)
            for written, left in product(range(self.ring.size + 1), torn):
                self.boot(image)
                self.save(NEW, written, left)
                found = self.boot()
                if found not in allowed or (
                    written == self.ring.size and found != self.as_restored(NEW)
                ):
                    yield f"cut after {written} bytes in slot {slot + 1}, {left} torn: {found}"

    def first_cuts(self) -> Iterator[str]:
        """The very first save is cut short, twice: the defaults, and no fault."""
        for written, left in product(range(self.ring.size), TORN):
            self.boot(bytes([BLANK]) * self.ring.bytes)
            for _ in range(2):
                self.save(NEW, written, left)
                found = self.boot()
                if found not in (self._default, self.as_restored(NEW)):
                    yield f"first save cut after {written} bytes, {left} torn: {found}"
            self.save(NEW)
            if self.boot() != self.as_restored(NEW):
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
            image[slot * ring.size + random.randrange(ring.size)] ^= random.randrange(1, 256)
        found = self.boot(bytes(image))
        ages = {age: (newest - age) % ring.slots for age in range(ring.slots)}
        valid = [slot for slot in ages.values() if ring.is_valid(ring.at(bytes(image), slot))]
        if not valid:
            wanted = self._default._replace(code=SETTINGS_CORRUPT)
        else:
            _, code, _, temperature_c, time_s = struct.unpack_from(
                "<HBBfI", ring.at(bytes(image), valid[0])
            )
            setpoint_c = found.setpoint_c  # judged by `setpoints`
            wanted = Stored(code, temperature_c, time_s, setpoint_c)
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
            if self.boot(image) != self._default._replace(code=code):
                yield f"{damaged} damaged records give {self.now()}"

    def codes(self) -> Iterator[str]:
        """A fault of another firmware is a fault, and acknowledgements begin anew."""
        for code in (0, 1, LAST_CODE, LAST_CODE + 1, 255):
            self.boot(self.ring.image({3: self.ring.record(7, OLD._replace(code=code), 200)}))
            wanted = code if code <= LAST_CODE else SETTINGS_CORRUPT
            if self.now().code != wanted or self.host.library.fault.acknowledgements:
                yield f"code {code} is restored as {self.now()}"

    def setpoints(self) -> Iterator[str]:
        """A stored setpoint counts only where the operator may go."""
        if not self.ring.stores_setpoint:
            return
        setpoint = self.ring.loop.setpoint
        low, high = setpoint.minimum_c, setpoint.maximum_c
        for value in (low, high, low - 0.01, high + 0.01, float("nan"), float("inf"), -1e30):
            self.boot(self.ring.image({0: self.ring.record(1, Stored(setpoint_c=value))}))
            wanted = value if low <= value <= high else setpoint.initial_c
            if self.now().setpoint_c != wanted:
                yield f"setpoint {value} is restored as {self.now().setpoint_c}"

    def foreign(self) -> Iterator[str]:
        """Records of a firmware with another digest do not count."""
        image = self.full(5, 5)
        other = bytes(byte ^ 0x10 if i % self.ring.size == self.ring.size - 1 else byte
                      for i, byte in enumerate(image))  # fmt: skip
        if self.boot(other).code != SETTINGS_CORRUPT:
            yield f"another firmware's records give {self.now()}"

    def later(self) -> Iterator[str]:
        """A setpoint is saved when it has rested for 10 s."""
        if not self.ring.stores_setpoint:
            return
        library, world = self.host.library, self.host.world
        self.boot(bytes([BLANK]) * self.ring.bytes)
        for rest in (500, DELAY_TICKS - 1):
            library.settings_save_later()
            before = world.eeprom_writes
            for _ in range(rest):
                library.settings_tick()
            if world.eeprom_writes != before:
                yield f"saved within {rest} ticks"
        for _ in range(3):
            library.settings_tick()
        if world.eeprom_writes == before:
            yield "not saved after 10 s"

    def wear(self) -> Iterator[str]:
        """Every cell is written once in a turn of the ring, one byte a tick."""
        self.boot(bytes([BLANK]) * self.ring.bytes)
        for number in range(self.ring.slots):
            before = self.host.world.eeprom_writes
            self.save(OLD._replace(time_s=number))
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
        library.fault.code = OLD.code
        library.settings_save()
        before = self.host.world.eeprom_writes
        for _ in range(5):
            library.settings_tick()
        self.save(NEW)
        if self.host.world.eeprom_writes - before != 2 * self.ring.size:
            yield "a record is not finished before the next one"
        if self.boot() != self.as_restored(NEW):
            yield f"a change while writing is lost: {self.now()}"

    def latch(self) -> Iterator[str]:
        """The first fault stays, also without power; acknowledged, it is gone for good."""
        library = self.host.library
        self.boot(bytes([BLANK]) * self.ring.bytes)
        library.fault_trip(OLD.code, OLD.temperature_c)
        library.fault_trip(NEW.code, NEW.temperature_c)
        library.host_settle()
        if self.boot()[:2] != OLD[:2]:
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


def storage_problem(host: Host) -> str:
    """Run every check once, in a shorter form; say the first few things that are wrong."""
    storage = Storage(host)
    checks = [
        storage.blank(), storage.newest(), storage.cuts(range(1, storage.ring.slots, 36)),
        storage.first_cuts(), storage.few_damaged(), storage.codes(), storage.setpoints(),
        storage.foreign(), storage.later(), storage.wear(), storage.late_change(),
        storage.latch(),
        *(storage.damaged(seed) for seed in range(12)), storage.noise(1), storage.outside(),
    ]  # fmt: skip
    for check in checks:
        for problem in check:
            return problem
    return ""
