"""Whether the progress of a program survives what an EEPROM goes through: a ring of records."""

from collections.abc import Iterator
from itertools import product
from typing import Any

from storage_format import PROGRESS_BYTES, Progress
from storage_host import Kept

from heatwright.sim.host import Host
from heatwright.sim.host.layout import declarations

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

    # ---- the checks ----

    def blank(self) -> Iterator[str]:
        """Nothing is found, nothing is written, and nothing counted."""
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
        host.erase()
        host.power_up()
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
