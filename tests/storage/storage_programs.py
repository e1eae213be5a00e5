"""Whether programs survive what an EEPROM goes through: two slots for each place."""

from collections.abc import Callable, Iterable, Iterator
from itertools import product
from typing import Any

from storage_format import FAST, HOLD, OVER, RATE, UNTIL, Segment, Stored
from storage_host import TORN, Kept

from heatwright.sim.host import Host

LONGEST_S = 31 * 86400
OLD = Stored(b"old", (Segment(OVER, 301, 60), Segment(HOLD, 0, LONGEST_S)))
NEW = Stored(b"new one 12ch", (Segment(RATE, -50, 65535), Segment(FAST, 905), Segment(UNTIL)))
EMPTY = Stored(b"", ())


class Programs(Kept):
    """One place, whose neighbours must stay as they are."""

    checks = (
        "blank", "one_slot", "emptied", "unchanged", "one_at_a_time", "first_turn", "half",
        "foreign", "behind", "twins", "unsound_in_eeprom", "sound", "crc", "noise", "damaged",
        "newest", "cut_while_emptied", "cuts", "first_cuts", "torn", "beyond",
    )  # fmt: skip
    old, new = OLD, NEW
    slots = 2
    turns = (0, 1, 127, 128, 200, 255)

    def __init__(self, host: Host, *, short: bool = False) -> None:
        super().__init__(host, short=short)
        self.number, self.size = 2, self.memory.program_bytes
        self.slot_bytes = self.memory.program_slot

    def packed(self, stored: Stored) -> Any:
        raw = stored.packed(max(self.memory.points, len(stored.segments)))
        made = self.ffi.new("struct stored_program *")
        self.ffi.buffer(made)[:] = raw[: self.ffi.sizeof("struct stored_program")]
        return made

    def read(self, number: int) -> Stored | None:
        into = self.ffi.new("struct stored_program *")
        if not self.library.programs_read(number, into):
            return None
        return Stored.of(bytes(self.ffi.buffer(into)))

    def write(self, number: int, stored: Stored) -> bool:
        return bool(self.library.programs_write(number, self.packed(stored)))

    def save(self, value: Stored) -> None:
        assert self.write(self.number, value), "it is not taken"
        assert self.found() == self.as_found(value), "while it is written another one is read"

    def found(self) -> Stored | None:
        return self.read(self.number)

    @staticmethod
    def as_found(value: Stored) -> Stored | None:
        return value if value.segments else None

    def known(self, image: bytes) -> Stored | None:
        return self.memory.program(image, self.number)

    def slot_at(self, slot: int) -> int:
        return self.memory.program_at(self.number, slot)

    def used(self, slot: int, turn: int) -> bytes:
        """With a program at every place, and an older one in its other slot."""
        pieces = []
        for place, each in product(range(1, self.memory.places + 1), (0, 1)):
            mine = place == self.number and each == slot
            other = Stored(b"%d.%d" % (place, each), (Segment(HOLD, 0, place),))
            stored = self.memory.program_slot(turn - (each != slot), OLD if mine else other)
            pieces.append((self.memory.program_at(place, each), stored))
        return self.memory.image(*pieces)

    def beside(self, image: bytes, when: str, *, done: bool) -> Iterator[str]:
        if done and not self.library.programs_are_saved():
            yield f"{when}: it is never saved"
        for place in set(range(1, self.memory.places + 1)) - {self.number}:
            if self.read(place) != self.memory.program(image, place):
                yield f"{when}: place {place} has {self.read(place)}"

    def newest(self) -> Iterator[str]:
        yield from self._at((1, self.memory.places), super().newest)

    def cuts(self) -> Iterator[str]:
        places = self.memory.places
        numbers = (2,) if self.short else range(1, places + 1, 1 if places < 8 else 7)
        yield from self._at(numbers, super().cuts)

    def _at(self, numbers: Iterable[int], check: Callable[[], Iterator[str]]) -> Iterator[str]:
        for number in numbers:
            self.number = number
            yield from check()
        self.number = 2

    def cut_while_emptied(self) -> Iterator[str]:
        yield from self.cut_behind((0, 1), (0,) if self.short else TORN, EMPTY)

    def blank(self) -> Iterator[str]:
        """Without EEPROM, the spec's; places that are none have nothing."""
        self.boot(self.memory.blank)
        for number in range(self.memory.places + 2):
            if self.read(number) != self.memory.given(number):
                yield f"blank: place {number} has {self.read(number)}"
        if self.settle():
            yield "something is written although nothing has changed"
        behind = self.memory.places + 1
        sound = self.memory.program_slot(1, OLD)
        self.boot(self.memory.image((self.memory.program_at(behind, 0), sound)))
        for number in (0, behind, 255):
            if self.write(number, OLD):
                yield f"place {number} is written"
            if self.read(number):
                yield f"place {number} has something"

    def one_slot(self) -> Iterator[str]:
        """One of two is damaged: the other counts, whatever its turn."""
        for slot, turn in product((0, 1), (0, 255)):
            at = self.slot_at(slot)
            self.boot(self.memory.image((at, self.slot_bytes(turn, OLD))))
            yield from self.expect(f"only slot {slot}, turn {turn}", OLD)
            self.save(NEW)
            self.settle()
            if self.known(self.image) != NEW or self.image[at] != turn:
                yield f"beside slot {slot} it is not written to the other one"

    def emptied(self) -> Iterator[str]:
        """A place can be emptied, the spec's program and all, and filled again."""
        self.boot(self.memory.blank)
        for stored in (EMPTY, NEW, EMPTY, OLD):
            self.save(stored)
            self.settle()
            self.boot()
            yield from self.expect("changed", self.as_found(stored))
            yield from self.beside(self.memory.blank, "changed", done=True)

    def unchanged(self) -> Iterator[str]:
        """What is there already is not written again."""
        self.boot(self.memory.blank)
        other = OLD._replace(segments=(*OLD.segments[:1], Segment(HOLD, 0, 1)))
        first, second = self.memory.given(1), self.memory.given(2)
        assert first
        assert second
        for number, stored in (
            (1, first), (1, NEW), (2, second), (2, EMPTY), (2, OLD), (2, other), (1, EMPTY)
        ):  # fmt: skip
            beside, there = self.read(3 - number), self.read(number) or EMPTY
            for turn in range(2):
                if not self.write(number, stored):
                    yield f"{stored} is not taken"
                bytes_wanted = 0 if turn or there == stored else self.size
                if self.settle() != bytes_wanted:
                    yield f"{stored} at place {number}, {turn}: not {bytes_wanted} bytes"
                if self.read(3 - number) != beside:
                    yield "the place beside it has changed"
        if self.memory.places > 2:
            self.write(1, NEW)
            self.settle()
            self.write(self.memory.places, EMPTY)
            if self.settle():
                yield "an empty place is emptied"

    def one_at_a_time(self) -> Iterator[str]:
        """While one is written another is refused, and does it no harm."""
        self.boot(self.memory.blank)
        self.save(OLD)
        for written in range(self.size):
            if self.library.programs_are_saved() or self.write(1, NEW) or self.write(2, NEW):
                yield f"a second one is taken after {written} bytes"
            for place in {*range(1, self.memory.places + 1)} - {self.number}:
                if self.read(place) != self.memory.given(place):
                    yield "a place beside it has changed"
            self.tick()
        yield from self.expect("alone", OLD)
        yield from self.beside(self.memory.blank, "alone", done=True)

    def first_turn(self) -> Iterator[str]:
        """It is 0, whatever the next place's is."""
        self.boot(self.memory.image((self.slot_at(2), self.slot_bytes(7, OLD))))
        self.save(NEW)
        self.settle()
        if self.image[self.slot_at(0) :][: self.size] != self.slot_bytes(0, NEW):
            yield "the first turn is not 0"

    def unsound_in_eeprom(self) -> Iterator[str]:
        """A slot that is whole but says nonsense has no program."""
        for stored in (OLD._replace(name=b'"'), OLD._replace(segments=(Segment(6),))):
            self.boot(self.memory.image((self.slot_at(0), self.slot_bytes(1, stored))))
            yield from self.expect("unsound", None)

    def sound(self) -> Iterator[str]:
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


def _judged(points: int) -> Iterator[tuple[Stored, bool]]:
    """Programs, and whether they are sound; the setpoint goes from -5 to 90.5 °C."""
    names = {b"": True, b" ": True, b"~" * 12: True, b"x" * 13: False, b"a\x1f": False}
    names |= {b"\x7f": False, b'a"b': False, b"\\": False, b"\xe9": False, b"a\0\xff": True}
    for name, sound in names.items():
        yield Stored(name, OLD.segments), sound
    yield Stored(b"x" * 13, ()), False  # the 0 behind it is none of the name
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
