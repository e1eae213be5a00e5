"""Whether programs survive what an EEPROM goes through; each check says what is wrong, if any."""

from collections.abc import Iterable, Iterator
from itertools import product
from random import Random

from storage_format import FAST, HOLD, OVER, RATE, UNTIL, Segment, Stored
from storage_host import TORN, StorageHost

LONGEST_S = 31 * 86400
OLD = Stored(b"old", (Segment(OVER, 301, 60), Segment(HOLD, 0, LONGEST_S)))
NEW = Stored(b"new one 12ch", (Segment(RATE, -50, 65535), Segment(FAST, 905), Segment(UNTIL)))
EMPTY = Stored(b"", ())


class Programs(StorageHost):
    def expect(self, when: str, number: int, *wanted: Stored | None) -> Iterator[str]:
        found = self.read(number)
        if found not in wanted:
            yield f"{when}: place {number} has {found}"

    def stored(self, number: int, turn: int, *, slot: int = 0, stored: Stored = OLD) -> bytes:
        """An image with a program at a place, older ones in the other slot and all other places."""
        memory, pieces = self.memory, []
        for place, each in product(range(1, memory.places + 1), (0, 1)):
            mine = place == number and each == slot
            other = Stored(b"%d.%d" % (place, each), (Segment(HOLD, 0, place),))
            age = 0 if each == slot else 1
            program = memory.program_slot(turn - age, stored if mine else other)
            pieces.append((memory.program_at(place, each), program))
        return memory.with_at(memory.blank, *pieces)

    # ---- the checks ----

    def blank(self) -> Iterator[str]:
        """Without EEPROM, the spec's; places that are none have nothing."""
        self.boot(self.memory.blank)
        for number in range(self.memory.places + 2):
            yield from self.expect("blank", number, self.given(number) if number else None)
        if self.settle():
            yield "something is written although nothing has changed"
        for number in (0, self.memory.places + 1, 255):
            if self.write(number, OLD):
                yield f"place {number} is written"

    def newest(self, turns: Iterable[int] = (0, 1, 127, 128, 200, 255)) -> Iterator[str]:
        """The newer one counts, also where turns wrap; a new one goes to the other slot."""
        for number, slot, turn in product((1, self.memory.places), (0, 1), turns):
            self.boot(self.stored(number, turn, slot=slot))
            yield from self.expect(f"turn {turn} in slot {slot}", number, OLD)
            before = self.image
            if not self.write(number, NEW) or self.library.programs_are_saved():
                yield "it is not written"
            yield from self.expect("being written", number, NEW)
            if self.settle() != self.memory.program_bytes:
                yield "not every byte is written once"
            at = self.memory.program_at(number, 1 - slot)
            wanted = self.memory.with_at(before, (at, self.memory.program_slot(turn + 1, NEW)))
            if self.image != wanted:
                yield f"turn {turn} in slot {slot}: what is written is not as it should be"
            if not self.library.programs_are_saved():
                yield "it is never saved"
            self.boot()
            yield from self.expect("saved", number, NEW)

    def one_slot(self) -> Iterator[str]:
        """One of two is damaged: the other counts, whatever its turn."""
        memory = self.memory
        for slot, turn in product((0, 1), (0, 255)):
            piece = (memory.program_at(2, slot), memory.program_slot(turn, OLD))
            self.boot(memory.with_at(memory.blank, piece))
            yield from self.expect(f"only slot {slot}, turn {turn}", 2, OLD)
            self.write(2, NEW)
            self.settle()
            if memory.program(self.image, 2) != NEW or self.image[piece[0] :][:1] != bytes([turn]):
                yield f"beside slot {slot} it is not written to the other one"

    def cuts(
        self, numbers: Iterable[int], torn: Iterable[int] = TORN, new: Stored = NEW
    ) -> Iterator[str]:
        """The power fails at any byte of a program: the old or the new is there, at every place."""
        for number, slot in product(numbers, (0, 1)):
            image = self.stored(number, 255 - slot, slot=slot)
            others = {
                place: self.memory.program(image, place)
                for place in range(1, self.memory.places + 1)
                if place != number
            }
            old = self.memory.program(image, number)
            for written, left in product(range(self.memory.program_bytes + 1), torn):
                self.boot(image)
                self.write(number, new)
                self.cut_after(written, left)
                self.settle()
                self.boot()
                done = written == self.memory.program_bytes
                after = new if new.segments else None
                when = f"cut after {written} bytes, {left} torn"
                yield from self.expect(when, number, *([after] if done else [old, after]))
                for place, wanted in others.items():
                    yield from self.expect(when, place, wanted)

    def first_cuts(self) -> Iterator[str]:
        """The very first program of a place is cut short, twice, then it is written."""
        for written, left in product(range(self.memory.program_bytes), TORN):
            self.boot(self.memory.blank)
            for new in (NEW, OLD):
                self.write(2, new)
                self.cut_after(written, left)
                self.settle()
                self.boot()
                yield from self.expect(
                    f"first, cut after {written} bytes, {left} torn", 2, self.given(2), NEW, OLD
                )
            self.write(2, NEW)
            self.settle()
            self.boot()
            yield from self.expect(f"again, after {written} bytes, {left} torn", 2, NEW)

    def emptied(self) -> Iterator[str]:
        """A place can be emptied, the spec's program and all, and filled again."""
        self.boot(self.memory.blank)
        for stored, wanted in ((EMPTY, None), (NEW, NEW), (EMPTY, None), (OLD, OLD)):
            if not self.write(1, stored):
                yield f"{stored} is not taken"
            yield from self.expect("being written", 1, wanted)
            self.settle()
            self.boot()
            yield from self.expect("changed", 1, wanted)
            yield from self.expect("left alone", 2, self.given(2))

    def unchanged(self) -> Iterator[str]:
        """What is there already is not written again."""
        self.boot(self.memory.blank)
        other = OLD._replace(segments=(*OLD.segments[:1], Segment(HOLD, 0, 1)))
        for number, stored in (
            (1, self.given(1)), (1, NEW), (2, self.given(2)), (2, EMPTY), (2, OLD), (2, other),
            (1, EMPTY),
        ):  # fmt: skip
            assert stored is not None
            beside = self.read(3 - number)
            there = self.read(number) or EMPTY
            for turn in range(2):
                if not self.write(number, stored):
                    yield f"{stored} is not taken"
                bytes_wanted = 0 if turn or there == stored else self.memory.program_bytes
                if self.settle() != bytes_wanted:
                    yield f"{stored} at place {number}, {turn}: not {bytes_wanted} bytes"
                yield from self.expect("beside it", 3 - number, beside)
        if self.memory.places > len(self.programs.stored):
            self.write(self.memory.places, EMPTY)
            if self.settle():
                yield "an empty place is emptied"

    def one_at_a_time(self) -> Iterator[str]:
        """While one is written another is refused, and does it no harm."""
        self.boot(self.memory.blank)
        self.write(1, OLD)
        for written in range(self.memory.program_bytes):
            if self.library.programs_are_saved() or self.write(2, NEW) or self.write(1, NEW):
                yield f"a second one is taken after {written} bytes"
            yield from self.expect("beside it", 2, self.given(2))
            self.tick()
        yield from self.expect("alone", 2, self.given(2))
        yield from self.expect("alone", 1, OLD)

    def half(self) -> Iterator[str]:
        """A slot that was cut short, and whose CRC is right by chance, does not count."""
        memory = self.memory
        for turn, last in ((7, 5), (0, 0xFF)):
            slot = memory.program_slot(turn, OLD)[:-1] + bytes([last])
            self.boot(memory.with_at(memory.blank, (memory.program_at(2, 0), slot)))
            yield from self.expect("cut short", 2, self.given(2))
            self.write(2, NEW)
            self.settle()
            at = memory.program_at(2, 0)
            if self.image[at : at + memory.program_bytes] != memory.program_slot(0, NEW):
                yield "the first turn is not 0"

    def foreign(self) -> Iterator[str]:
        """What another spec has left counts for nothing."""
        other = bytes([self.memory.digest[0] ^ 1, *self.memory.digest[1:]])
        slot = self.memory.program_slot(7, OLD, other)
        at = [self.memory.program_at(2, each) for each in (0, 1)]
        self.boot(self.memory.with_at(self.memory.blank, (at[0], slot), (at[1], slot)))
        yield from self.expect("another spec's", 2, self.given(2))

    def unsound_in_eeprom(self) -> Iterator[str]:
        """A slot that is whole but says nonsense has no program."""
        for stored in (OLD._replace(name=b'"'), OLD._replace(segments=(Segment(6),))):
            slot = (self.memory.program_at(2, 0), self.memory.program_slot(1, stored))
            self.boot(self.memory.with_at(self.memory.blank, slot))
            yield from self.expect("unsound", 2, None)

    def damaged(self, seed: int) -> Iterator[str]:
        """Any byte of a slot is another one: the other slot's program counts."""
        random = Random(seed)  # noqa: S311
        number, slot = random.randint(1, self.memory.places), random.randrange(2)
        image = bytearray(self.stored(number, seed & 0xFF, slot=slot))
        at = self.memory.program_at(number, slot) + random.randrange(self.memory.program_bytes)
        image[at] ^= random.randrange(1, 256)
        self.boot(bytes(image))
        yield from self.expect(f"damage {seed}", number, self.memory.program(bytes(image), number))

    def noise(self, seed: int) -> Iterator[str]:
        """Any bytes at all: the spec's programs."""
        self.boot(Random(seed).randbytes(self.memory.bytes))  # noqa: S311
        for number in range(1, self.memory.places + 1):
            yield from self.expect(f"noise {seed}", number, self.given(number))

    def sound(self) -> Iterator[str]:
        """What may be stored, and what may not."""
        self.boot(self.memory.blank)
        for stored, wanted in _judged(self.memory.points):
            if bool(self.library.programs_are_sound(self.packed(stored))) != wanted:
                yield f"{stored} is {'un' * wanted}sound"
            if not wanted and (self.write(1, stored) or self.settle()):
                yield f"{stored} is written"
        for count in (self.memory.points + 1, 255):
            raw = bytearray(Stored(b"", (Segment(HOLD, 0, 1),) * 255).packed(255))
            raw[13] = count
            program = self.ffi.from_buffer("uint8_t[]", raw)
            if self.library.programs_are_sound(self.ffi.cast("struct stored_program *", program)):
                yield f"{count} segments are sound"

    def crc(self) -> Iterator[str]:
        """It tells programs apart by all that they do, and by nothing else."""
        for stored in (OLD, NEW, EMPTY):
            raw = self.packed(stored)
            first = self.library.programs_crc(raw)
            if first != stored.crc:
                yield f"{stored} has CRC {first}"
            if len(stored.segments) < self.memory.points:
                raw.segment[len(stored.segments)].amount = 1
                if self.library.programs_crc(raw) != first:
                    yield "what is behind the last segment counts"

    def beyond(self) -> Iterator[str]:
        if self.outside:
            yield f"{self.outside} accesses outside the EEPROM"


def _judged(points: int) -> Iterator[tuple[Stored, bool]]:
    """Programs, and whether they are sound; the setpoint goes from -5 to 90.5 °C."""
    names = {b"": True, b" ": True, b"~" * 12: True, b"x" * 13: False, b"a\x1f": False}
    names |= {b"\x7f": False, b'a"b': False, b"\\": False, b"\xe9": False, b"a\0\xff": True}
    for name, sound in names.items():
        yield Stored(name, OLD.segments), sound
    for kind, (to_dc, inside) in product(
        (OVER, RATE, FAST), {-51: False, -50: True, 905: True, 906: False}.items()
    ):
        yield Stored(b"to", (Segment(kind, to_dc, 1),)), inside
    for kind in (HOLD, UNTIL):
        yield Stored(b"stay", (Segment(kind, 32767, 1),)), True
    for kind, most in ((OVER, LONGEST_S), (HOLD, LONGEST_S), (RATE, 65535)):
        for amount in (0, 1, most, most + 1, 2**32 - 1):
            yield Stored(b"amount", (Segment(kind, 100, amount),)), 1 <= amount <= most
    for kind in (FAST, UNTIL):
        for amount in (0, 2**32 - 1):
            yield Stored(b"none", (Segment(kind, 100, amount),)), True
    for kind in (0, 6, 255):
        yield Stored(b"kind", (Segment(HOLD, 0, 1), Segment(kind, 100, 1))), False
    yield Stored(b"full", (Segment(HOLD, 0, 1),) * points), True
    yield Stored(b"last", (*(Segment(HOLD, 0, 1),) * (points - 1), Segment(0))), False


def programs_problem(checked: Programs) -> str:
    """Run every check once, in a shorter form; say the first thing that is wrong."""
    checks = [
        checked.blank(), checked.newest((0, 128)), checked.one_slot(), checked.cuts((2,), (-1,)),
        checked.cuts((1,), (0,), EMPTY), checked.first_cuts(), checked.emptied(),
        checked.unchanged(), checked.one_at_a_time(), checked.foreign(), checked.half(),
        checked.sound(), checked.crc(), checked.unsound_in_eeprom(), checked.noise(1),
        *(checked.damaged(seed) for seed in range(20)), checked.beyond(),
    ]  # fmt: skip
    return next((problem for check in checks for problem in check), "")
