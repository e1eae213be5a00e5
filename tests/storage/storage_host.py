"""A host build of a machine with programs, whose power can be taken away while it writes."""

import re
from typing import Any

from storage_format import FAST, HOLD, OVER, RATE, UNTIL, Memory, Progress, Segment, Stored

from heatwright.sim.host import Host, HostBuild
from heatwright.sim.host.layout import declarations
from heatwright.spec import Controller

TORN = (-1, 0xFF, 0x00, 0x5A)
"""What an interrupted write leaves in its byte: the old value, an erased cell, anything."""


def given_at(controller: Controller, number: int) -> Stored | None:
    """What the spec has at a place."""
    programs = controller.programs
    assert programs is not None
    if number > len(programs.stored):
        return None
    program = programs.stored[number - 1]
    kinds = {"over": OVER, "rate": RATE, "fast": FAST, "hold": HOLD, "until": UNTIL}
    segments = []
    for each in program.segments:
        amount = each.over_s or each.hold_s or 10 * (each.at_k_per_h or 0)
        segments.append(Segment(kinds[each.kind], round(10 * (each.to_c or 0)), round(amount)))
    return Stored(program.name.encode(), tuple(segments))


def memory_of(build: HostBuild) -> Memory:
    """The memory, laid out as config.h says."""
    config = (build.project / "src" / "config.h").read_text(encoding="utf-8")

    def constant(name: str) -> int:
        return int(re.findall(rf"#define {name} (\d+)u", config)[0])

    memory = Memory(build.controller)
    memory.lay_out(
        constant("PROGRAMS_EEPROM"), constant("PROGRESS_EEPROM"), constant("PROGRESS_SLOTS")
    )
    return memory


class StorageHost:
    def __init__(self, build: HostBuild) -> None:
        self.host = Host(build)
        self.library: Any = self.host.library
        self.ffi = declarations(build.project, build.parts)
        self.memory = memory_of(build)
        self.controller = build.controller
        assert self.controller.programs is not None
        self.programs = self.controller.programs

    # ---- life ----

    def boot(self, image: bytes | None = None) -> None:
        """Power up, with another EEPROM if given."""
        if image is not None:
            self.host.eeprom[:] = image
        self.host.world.writes_left = self.host.world.torn = -1
        self.host.power_up()

    @property
    def image(self) -> bytes:
        return bytes(self.host.eeprom)

    def cut_after(self, written: int, torn: int = -1) -> None:
        """Let the power fail after so many bytes."""
        self.host.world.writes_left, self.host.world.torn = written, torn

    def tick(self, ticks: int = 1) -> int:
        """Only what writes; returns the bytes that it has."""
        before = self.host.world.eeprom_writes
        for _ in range(ticks):
            self.library.settings_tick()
            self.library.progress_tick()
            self.library.programs_tick()
        return int(self.host.world.eeprom_writes - before)

    def settle(self) -> int:
        """Write whatever is to be written; returns the bytes that it has."""
        before = self.host.world.eeprom_writes
        self.library.host_settle()
        return int(self.host.world.eeprom_writes - before)

    @property
    def outside(self) -> int:
        return int(self.host.world.eeprom_outside)

    # ---- programs ----

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

    def given(self, number: int) -> Stored | None:
        """What the spec has at a place."""
        return given_at(self.controller, number)

    # ---- progress ----

    def found(self) -> Progress | None:
        into = self.ffi.new("struct progress_record *")
        if not self.library.progress_found(into):
            return None
        return Progress(*(getattr(into, name) for name in Progress._fields))

    def note(self, record: Progress) -> None:
        """Let the program be there, and save that."""
        program = self.library.program
        for name in Progress._fields:
            if name not in {"program_crc", "temperature_c"}:
                setattr(program, name, getattr(record, name))
        self.library.loop_chamber.temperature_c = record.temperature_c
        self.library.progress_save()
