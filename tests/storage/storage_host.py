"""A host build whose power can be taken away while it writes, and what all that it keeps must bear;
the progress of a program among it: a ring of records. Each check says what is wrong, if anything
is."""

from collections.abc import Callable, Iterable, Iterator
from itertools import product
from random import Random
from typing import Any

from storage_format import BLANK, PROGRESS_BYTES, Memory, Progress

from heatwright.sim.host import Host
from heatwright.sim.host.layout import declarations

TORN = (-1, BLANK, 0x00, 0x5A)
"""What an interrupted write leaves in its byte: the old value, an erased cell, anything."""


class Kept:
    """Something that is kept in slots, each with a number that says which is newer."""

    checks: tuple[str, ...]  # what it must stand, what is quick first
    old: Any
    new: Any
    size: int  # bytes of a slot that are written
    slots: int
    turns: tuple[int, ...]  # numbers, also those about which they wrap

    def __init__(self, host: Host, *, short: bool = False) -> None:
        """Take a host build; `short`: with a part of the numbers, for many builds."""
        self.short = short
        self.host = host
        self.library: Any = host.library
        self.parts = host.build.parts
        self.ffi = declarations(host.build.project, self.parts)
        self.controller = host.build.controller
        self.memory = Memory(self.controller)
        writers = ("settings", *["progress", "programs"] * self.parts.programmed)
        self._ticks = [getattr(self.library, f"{each}_tick") for each in writers]

    save: Callable[[Any], None]  # let it be written from now on
    found: Callable[[], Any]  # what the firmware says it is
    known: Callable[[bytes], Any]  # what the firmware has to say it is, with this EEPROM
    slot_at: Callable[[int], int]
    slot_bytes: Callable[..., bytes]
    """The bytes for a turn and a value, perhaps with the digest of another spec."""
    used: Callable[[int, int], bytes]
    """An EEPROM in use: every slot written, the newest, with this turn, with `old`."""

    def beside(self, image: bytes, when: str, *, done: bool) -> Iterator[str]:
        """What else must be so after one was saved, or cut short, over an EEPROM."""
        del image, when, done
        yield from ()

    def boot(self, image: bytes | None = None) -> None:
        if image is not None:
            self.host.eeprom[:] = image
        self.host.world.writes_left = self.host.world.torn = -1
        self.host.power_up()

    def in_ring(self, slot: int, turn: int, values: Iterable[Any]) -> bytes:
        """An EEPROM with these values, the newest first, at this slot and with this turn."""
        pieces = enumerate(self.slot_bytes(turn - age, each) for age, each in enumerate(values))
        return self.memory.image(*((self.slot_at((slot - n) % self.slots), p) for n, p in pieces))

    @property
    def image(self) -> bytes:
        return bytes(self.host.eeprom)

    def tick(self, ticks: int = 1) -> int:
        """Only what writes; returns the bytes that it has."""
        before = self.host.world.eeprom_writes
        for _ in range(ticks):
            for each in self._ticks:
                each()
        return int(self.host.world.eeprom_writes - before)

    def settle(self) -> int:
        """Write whatever is to be written; returns the bytes that it has."""
        before = self.host.world.eeprom_writes
        self.library.host_settle()
        return int(self.host.world.eeprom_writes - before)

    def saved(self, value: Any, written: int = -1, torn: int = -1) -> None:
        """Save, let the power fail after so many bytes, and let it come back."""
        self.save(value)
        self.host.world.writes_left, self.host.world.torn = written, torn
        self.settle()
        self.boot()

    def expect(self, when: str, *wanted: Any) -> Iterator[str]:
        found = self.found()
        if repr(found) not in map(repr, wanted):  # by chance sound, with a NaN, which is not itself
            yield f"{when}: {found}, not {wanted}"

    def problem(self) -> str:
        """Try everything; say the first thing that is wrong, if anything is."""
        found = (problem for check in self.checks for problem in getattr(self, check)())
        return next(found, "")

    def some_slots(self) -> Iterable[int]:
        return (0, self.slots - 1) if self.short else range(self.slots)

    def newest(self) -> Iterator[str]:
        """The newest is taken; the next goes to the slot behind it, every byte once."""
        for slot, turn in product(self.some_slots(), self.turns):
            when, image = f"number {turn} in slot {slot}", self.used(slot, turn)
            self.boot(image)
            yield from self.expect(when, self.old)
            self.save(self.new)
            if self.settle() != self.size:
                yield f"{when}: not every byte of the next is written once"
            following = self.slot_at((slot + 1) % self.slots)
            piece = (following, self.slot_bytes(turn + 1, self.new))
            if self.image != self.memory.with_at(image, piece):
                yield f"{when}: what is written is not as it should be"
            self.boot()
            yield from self.expect(f"{when}, saved", self.new)
            yield from self.beside(image, when, done=True)

    def cuts(self) -> Iterator[str]:
        """The power fails at any byte: the old or the new is there, and all else as it was."""
        yield from self.cut_behind(self.some_slots(), (-1, 0) if self.short else TORN, self.new)

    def torn(self) -> Iterator[str]:
        """So it is whatever a torn write leaves."""
        if not self.short:
            every = 1 if self.slots < 50 and self.size < 80 else 17
            yield from self.cut_behind((1,), range(0, 256, every), self.new)

    def cut_behind(self, slots: Iterable[int], torn: Iterable[int], new: Any) -> Iterator[str]:
        for slot in slots:
            image = self.used(slot, self.turns[-1] - slot)
            for written, left in product(range(self.size + 1), torn):
                self.boot(image)
                self.saved(new, written, left)
                when = f"cut after {written} bytes behind slot {slot}, {left} torn"
                done = written == self.size
                yield from self.expect(when, self.as_found(new), *([] if done else [self.old]))
                yield from self.beside(image, when, done=done)

    @staticmethod
    def as_found(value: Any) -> Any:
        return value

    def first_cuts(self) -> Iterator[str]:
        """The very first one is cut short, twice, then it is written."""
        for written, left in product(range(self.size), TORN):
            self.boot(self.memory.blank)
            nothing = self.found()
            for value in (self.new, self.old):
                self.saved(value, written, left)
                when = f"first, cut after {written} bytes, {left} torn"
                yield from self.expect(when, nothing, self.new, self.old)
            self.saved(self.new)
            yield from self.expect(f"again, after {written} bytes, {left} torn", self.new)

    def foreign(self) -> Iterator[str]:
        """What another spec has left counts for nothing, whichever byte of its digest differs."""
        self.boot(self.memory.blank)
        nothing = self.found()
        for byte in range(4):
            other = bytearray(self.memory.digest)
            other[byte] ^= 0x81
            piece = self.slot_bytes(9, self.old, bytes(other))
            every = [(self.slot_at(slot), piece) for slot in range(self.slots)]
            self.boot(self.memory.image(*every))
            yield from self.expect("another spec's", nothing)
            self.saved(self.new)
            yield from self.expect("saved among another spec's", self.new)

    def behind(self) -> Iterator[str]:
        """What stands behind the last slot is none of it."""
        self.boot(self.memory.blank)
        nothing, at = self.found(), self.slot_at(self.slots)
        if at + self.size <= self.memory.bytes:
            self.boot(self.memory.image((at, self.slot_bytes(9, self.old))))
            yield from self.expect("behind the last slot", nothing)

    def twins(self) -> Iterator[str]:
        """The first of two with the same number counts."""
        for one, other in ((self.old, self.new), (self.new, self.old)):
            first, second = self.slot_bytes(9, one), self.slot_bytes(9, other)
            self.boot(self.memory.image((self.slot_at(0), first), (self.slot_at(1), second)))
            yield from self.expect("twins", one)

    def half(self) -> Iterator[str]:
        """A slot that was cut short, and whose CRC is right by chance, does not count."""
        self.boot(self.memory.blank)
        nothing = self.found()
        for turn, last in ((7, 5), (5, 7), (57, 1), (255, 0)):
            piece = self.slot_bytes(turn, self.old)[:-1] + bytes([last])
            self.boot(self.memory.image((self.slot_at(0), piece)))
            yield from self.expect("cut short", nothing)

    def damaged(self) -> Iterator[str]:
        """Some slots are damaged: the newest of the others counts."""
        for seed in range(20 if self.short else 300):
            random = Random(seed)  # noqa: S311
            image = bytearray(self.used(random.randrange(self.slots), random.choice(self.turns)))
            spared = random.choice((0, 1, 1, self.slots // 2, self.slots))
            for slot in set(range(self.slots)) - set(random.sample(range(self.slots), spared)):
                image[self.slot_at(slot) + random.randrange(self.size)] ^= random.randrange(1, 256)
            self.boot(bytes(image))
            yield from self.expect(f"damage {seed}", self.known(bytes(image)))

    def noise(self) -> Iterator[str]:
        """Any bytes at all: nothing of it is taken, and no program runs."""
        for seed in range(2 if self.short else 150):
            image = Random(seed).randbytes(self.memory.bytes)  # noqa: S311
            self.boot(image)
            yield from self.expect(f"noise {seed}", self.known(image))
            if self.parts.programmed and self.library.program.state:
                yield f"noise {seed} makes a program run"

    def beyond(self) -> Iterator[str]:
        outside = int(self.host.world.eeprom_outside)
        if outside:
            yield f"{outside} accesses outside the EEPROM"


IDLE, RUNNING, PAUSED, RETURNING = range(4)
STOPPED = 2
OLD = Progress(IDLE, 1, 2, 3, 0, 20.5, 30.25, 40.125, -1.5, 11, 2**31, 33, 2**32 - 1)
NEW = Progress(IDLE, 2, 3, 1, 0, -3.5, 1.5e-3, 88.0, 1100.25, 2**24 - 1, 5, 6, 7)
"""Idle, so that a start does not go on with them; the CRC is that of no program."""


class Progresses(Kept):
    checks = (
        "blank", "ordered", "half", "foreign", "behind", "twins", "wishes", "wear", "noise",
        "damaged", "newest", "cuts", "first_cuts", "torn", "beyond",
    )  # fmt: skip
    size = PROGRESS_BYTES

    def __init__(self, host: Host, *, short: bool = False) -> None:
        super().__init__(host, short=short)
        self.slots, self.slot_bytes = self.memory.progress_slots, self.memory.progress_slot
        self.turns = (1, 2, self.slots, 255, 256, 65536, 2**32 - 2)
        self.boot(self.memory.blank)
        crc = self.library.programs_crc(self.library.program_loaded())
        self.old, self.new = (self._exact(each._replace(program_crc=crc)) for each in (OLD, NEW))

    def _exact(self, record: Progress) -> Progress:
        """The record with its numbers as a float holds them."""
        image = self.memory.image((self.slot_at(0), self.slot_bytes(0, record)))
        found = self.memory.progress_in(image, 0)
        assert found is not None
        return found[1]

    def save(self, value: Progress) -> None:
        for name in set(Progress._fields) - {"program_crc", "temperature_c"}:
            setattr(self.library.program, name, getattr(value, name))
        self.library.loop_chamber.temperature_c = value.temperature_c
        self.library.progress_save()

    def found(self) -> Progress | None:
        into = self.ffi.new("struct progress_record *")
        if not self.library.progress_found(into):
            return None
        return Progress(*(getattr(into, name) for name in Progress._fields))

    def known(self, image: bytes) -> Progress | None:
        found = self.memory.progress(image)
        return found and found[1]

    def slot_at(self, slot: int) -> int:
        return self.memory.progress_at + slot * PROGRESS_BYTES

    def used(self, slot: int, turn: int) -> bytes:
        ages = range(1, min(self.slots, turn))
        aged = (self.old._replace(ended=age & 0xFF) for age in ages)
        return self.in_ring(slot, turn, (self.old, *aged))

    def beside(self, image: bytes, when: str, *, done: bool) -> Iterator[str]:
        newest = self.memory.progress(image)
        before = newest[0] if newest else 0
        saves = self.library.progress_saves()
        if saves != before + 1 and (done or saves != before):
            yield f"{when}: {saves} saves are counted"

    def blank(self) -> Iterator[str]:
        self.boot(self.memory.blank)
        yield from self.expect("blank", None)
        if self.library.progress_saves():
            yield "blank: saves are counted"
        if self.settle():
            yield "something is written although nobody wants it"

    def ordered(self) -> Iterator[str]:
        yield from ordered_wrongly(self.host)

    def wishes(self) -> Iterator[str]:
        """A wish while one is written is fulfilled behind it, with what is then; many are one."""
        self.boot(self.memory.blank)
        self.save(self.old)
        self.tick(5)
        self.save(self.new._replace(number=9))
        self.save(self.new)
        if self.settle() != 2 * PROGRESS_BYTES - 4:
            yield "two wishes while a record is written are not one record"
        found = [self.memory.progress_in(self.image, slot) for slot in (1, 2, 3)]
        if found != [(1, self.old), (2, self.new), None]:
            yield f"{found} was written"

    def wear(self) -> Iterator[str]:
        """Every cell is written once in a turn of the ring."""
        self.boot(self.memory.blank)
        for number in range(1, self.slots + 1):
            self.save(self.old._replace(clock=number))
            if self.settle() != PROGRESS_BYTES:
                yield f"save {number} writes another number of bytes"
        for number in range(1, self.slots + 1):
            found = self.memory.progress_in(self.image, number % self.slots)
            if found != (number, self.old._replace(clock=number)):
                yield f"save {number} has left {found}"


def ordered_wrongly(host: Host) -> Iterator[str]:
    """An order to stop or to pause is noted as it will be obeyed: the power may go before that."""
    library: Any = host.library
    ffi = declarations(host.build.project, host.build.parts)
    orders = ("", "stop", "pause", "skip")
    for state, order in (*product(range(5), orders), (IDLE, "start and pause")):
        host.renew()
        library.program.state, library.program.ended = state, 1
        if order == "start and pause":  # nothing has begun that could be paused
            assert library.program_start(1)
        given = order.rpartition(" ")[2]
        taken = bool(getattr(library, f"program_{given}")()) if given else False
        record = ffi.new("struct progress_record *")
        library.program_note(record)
        fits = {"stop": state != IDLE, "pause": state in {RUNNING, RETURNING}}
        may = (fits | {"skip": state == RUNNING}).get(order, False)
        wanted = {"stop": (IDLE, STOPPED), "pause": (PAUSED, 1)}.get(
            order if may else "", (state, 1)
        )
        may |= given != order
        if (taken, record.state, record.ended) != (may, *wanted):
            yield f"{order or 'nothing'} in state {state} is noted as {record.state}, not {wanted}"
