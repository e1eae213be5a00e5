"""Whether the progress of a program survives what an EEPROM goes through."""

from collections.abc import Iterable, Iterator
from itertools import product
from random import Random

from storage_format import PROGRESS_BYTES, Progress
from storage_host import TORN, StorageHost

IDLE = 0
OLD = Progress(IDLE, 1, 2, 3, 0, 20.5, 30.25, 40.125, -1.5, 11, 2**31, 33, 2**32 - 1)
NEW = Progress(IDLE, 2, 3, 1, 0, -3.5, 1e-3, 88.0, 1100.25, 2**24 - 1, 5, 6, 7)
"""Idle, so that a start does not go on with them; the CRC is that of no program."""


class Progresses(StorageHost):
    def __init__(self, *given: object) -> None:
        super().__init__(*given)  # type: ignore[arg-type]
        self.boot(self.memory.blank)
        crc = self.library.programs_crc(self.library.program_loaded())
        self.old, self.new = (self._exact(each, crc) for each in (OLD, NEW))

    def _exact(self, record: Progress, crc: int) -> Progress:
        """The record with its numbers as a float holds them."""
        raw = self.memory.progress_slot(0, record._replace(program_crc=crc))
        image = self.memory.with_at(self.memory.blank, (self.memory.progress_at, raw))
        found = self.memory.progress_in(image, 0)
        assert found is not None
        return found[1]

    def used(self, newest: int, sequence: int) -> bytes:
        """A ring in use: every slot written, the newest at `newest` with `sequence`."""
        memory, pieces = self.memory, []
        for age in range(min(memory.progress_slots, sequence)):
            slot = (newest - age) % memory.progress_slots
            record = self.old if age == 0 else self.old._replace(ended=age & 0xFF)
            at = memory.progress_at + slot * PROGRESS_BYTES
            pieces.append((at, memory.progress_slot(sequence - age, record)))
        return memory.with_at(memory.blank, *pieces)

    def expect(self, when: str, *wanted: Progress | None) -> Iterator[str]:
        if self.found() not in wanted:
            yield f"{when}: {self.found()}"

    def expect_saves(self, when: str, *wanted: int) -> Iterator[str]:
        if self.library.progress_saves() not in wanted:
            yield f"{when}: {self.library.progress_saves()} saves are counted"

    # ---- the checks ----

    def blank(self) -> Iterator[str]:
        """Nothing is found, nothing is written, and nothing counted."""
        self.boot(self.memory.blank)
        yield from self.expect("blank", None)
        yield from self.expect_saves("blank", 0)
        if self.settle():
            yield "something is written although nobody wants it"

    def newest(self, slots: Iterable[int]) -> Iterator[str]:
        """The newest is taken; the next goes to the slot behind it, every byte once."""
        last = self.memory.progress_slots
        for slot, sequence in product(slots, (1, 2, last, 255, 256, 65536, 2**32 - 2)):
            image = self.used(slot, sequence)
            self.boot(image)
            when = f"newest in slot {slot}, number {sequence}"
            yield from self.expect(when, self.old)
            yield from self.expect_saves(when, sequence)
            self.note(self.new)
            if self.settle() != PROGRESS_BYTES:
                yield f"{when}: not {PROGRESS_BYTES} bytes are written"
            at = self.memory.progress_at + (slot + 1) % last * PROGRESS_BYTES
            wanted = self.memory.with_at(
                image, (at, self.memory.progress_slot(sequence + 1, self.new))
            )
            if self.image != wanted:
                yield f"{when}: what is written is not as it should be"
            yield from self.expect_saves(when, sequence + 1)
            self.boot()
            yield from self.expect(f"{when}, saved", self.new)

    def cuts(self, slots: Iterable[int], torn: Iterable[int] = TORN) -> Iterator[str]:
        """The power fails at any byte of a record in any slot: the old or the new is there."""
        for slot in slots:
            sequence = 1000 + slot
            image = self.used(slot, sequence)
            for written, left in product(range(PROGRESS_BYTES + 1), torn):
                self.boot(image)
                self.note(self.new)
                self.cut_after(written, left)
                self.settle()
                self.boot()
                when = f"cut after {written} bytes behind slot {slot}, {left} torn"
                done = written == PROGRESS_BYTES
                yield from self.expect(when, *([self.new] if done else [self.old, self.new]))
                yield from self.expect_saves(when, sequence + 1, *([] if done else [sequence]))

    def first_cuts(self) -> Iterator[str]:
        """The very first record is cut short, twice, then it is written."""
        for written, left in product(range(PROGRESS_BYTES), TORN):
            self.boot(self.memory.blank)
            for record in (self.new, self.old):
                self.note(record)
                self.cut_after(written, left)
                self.settle()
                self.boot()
                when = f"first, cut after {written} bytes, {left} torn"
                yield from self.expect(when, None, self.new, self.old)
            self.note(self.new)
            self.settle()
            self.boot()
            yield from self.expect(f"again, after {written} bytes, {left} torn", self.new)

    def wishes(self) -> Iterator[str]:
        """A wish while one is written is fulfilled behind it, with what is then; many are one."""
        self.boot(self.memory.blank)
        self.note(self.old)
        self.tick(5)
        self.note(self.new._replace(number=9))
        self.note(self.new)
        if self.settle() != 2 * PROGRESS_BYTES - 4:
            yield "two wishes while a record is written are not one record"
        found = [self.memory.progress_in(self.image, slot) for slot in (1, 2, 3)]
        if found != [(1, self.old), (2, self.new), None]:
            yield f"{found} was written"

    def wear(self) -> Iterator[str]:
        """Every cell is written once in a turn of the ring."""
        self.boot(self.memory.blank)
        for number in range(1, self.memory.progress_slots + 1):
            self.note(self.old._replace(clock=number))
            if self.settle() != PROGRESS_BYTES:
                yield f"save {number} writes another number of bytes"
        for number in range(1, self.memory.progress_slots + 1):
            found = self.memory.progress_in(self.image, number % self.memory.progress_slots)
            if found != (number, self.old._replace(clock=number)):
                yield f"save {number} has left {found}"

    def half(self) -> Iterator[str]:
        """A slot that was cut short, and whose CRC is right by chance, does not count."""
        slot = self.memory.progress_slot(57, self.old)[:-1] + b"\x01"
        self.boot(self.memory.with_at(self.memory.blank, (self.memory.progress_at, slot)))
        yield from self.expect("cut short", None)

    def foreign(self) -> Iterator[str]:
        """What another spec has left counts for nothing, and does not count."""
        memory = self.memory
        other = bytes([*memory.digest[:3], memory.digest[3] ^ 0x80])
        pieces = [
            (memory.progress_at + slot * PROGRESS_BYTES, memory.progress_slot(9, self.old, other))
            for slot in range(memory.progress_slots)
        ]
        self.boot(memory.with_at(memory.blank, *pieces))
        yield from self.expect("another spec's", None)
        yield from self.expect_saves("another spec's", 0)

    def damaged(self, seed: int) -> Iterator[str]:
        """Some slots are damaged: the newest of the others counts."""
        random = Random(seed)  # noqa: S311
        slots = self.memory.progress_slots
        newest = random.randrange(slots)
        image = bytearray(self.used(newest, random.choice((slots, 300, 70000))))
        spared = random.choice((0, 1, 1, slots // 2, slots))
        for slot in set(range(slots)) - set(random.sample(range(slots), spared)):
            at = self.memory.progress_at + slot * PROGRESS_BYTES
            image[at + random.randrange(PROGRESS_BYTES)] ^= random.randrange(1, 256)
        self.boot(bytes(image))
        wanted = self.memory.progress(bytes(image))
        yield from self.expect(f"damage {seed}", wanted and wanted[1])

    def noise(self, seed: int) -> Iterator[str]:
        """Any bytes at all: nothing is found, and nothing goes on."""
        self.boot(Random(seed).randbytes(self.memory.bytes))  # noqa: S311
        yield from self.expect(f"noise {seed}", None)
        if self.library.program.state != IDLE:
            yield f"noise {seed} makes a program run"

    def beyond(self) -> Iterator[str]:
        if self.outside:
            yield f"{self.outside} accesses outside the EEPROM"


def progress_problem(checked: Progresses) -> str:
    """Run every check once, in a shorter form; say the first thing that is wrong."""
    last = checked.memory.progress_slots - 1
    checks = [
        checked.blank(), checked.newest((0, last)), checked.cuts((0, last), (-1, 0)),
        checked.first_cuts(), checked.wishes(), checked.wear(), checked.half(), checked.foreign(),
        *(checked.damaged(seed) for seed in range(20)), checked.noise(1), checked.beyond(),
    ]  # fmt: skip
    return next((problem for check in checks for problem in check), "")
