"""What must happen after a power cut, from the EEPROM's bytes and a temperature; and what does."""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import storage_firing as firing
from storage_format import PROGRESS_BYTES, Memory, Progress, Settings, Stored

from heatwright.sim.binary.elf import Elf
from heatwright.sim.device import AvrDevice
from heatwright.spec import Controller

STOPPED, FAILED, TOO_FAR, POWER_UNREADABLE = 2, 3, 4, 5
TICK_S = 0.01
SLICE_S = 2 * TICK_S
"""In which at most the relay is told to close; the heater waits five ticks for it."""
SEEN_EVERY_S = 0.1
FIRST_STEP_S = 1.0
DECIDED_BY_S = 4.0  # the converter's first reading takes 0.2 s, a step 1 s
WATCHED_S = 1.0
FULL_PERMILLE = 1000
LEAST_C = 5.0  # the machine's lowest temperature: well within what no rule takes for a fault


class Book:
    def __init__(self, controller: Controller) -> None:
        self.memory = Memory(controller)
        programs = controller.programs
        assert programs is not None
        self.within_k = programs.after_power_loss.resume_within_k
        self.pauses = programs.after_power_loss.otherwise == "pause"
        self.keeps = programs.on_fault == "pause"
        self.save_every_s = programs.save_every_s

    def record(self, image: bytes) -> Progress | None:
        found = self.memory.progress(image)
        return found and found[1]

    def forgotten(self, cuts: list[firing.Cut], edits: dict[int, list[firing.Edit]]) -> str:
        """Say which place has what nobody has put there, or an older program than before."""
        for place, sent in edits.items():
            newest = 0
            for cut in cuts:
                found = self.memory.program(cut.image, place)
                if newest == 0 and found == self.memory.given(place):
                    continue
                kept = found and found.segments
                later = [n for n, one in enumerate(sent, 1) if n >= newest and one.segments == kept]
                if not later or sent[later[0] - 1].time_s > cut.time_s:
                    return f"{cut.time_s:.6f} s: place {place} has {found}"
                newest = later[0]
        return ""

    def late_s(self) -> float:
        """Until a change is kept: a record of progress may be under way. Settings come first, and
        there may be two records of them in each step's time, a fault and its acknowledgement."""
        records_s = 2 * PROGRESS_BYTES * TICK_S
        settings_s = 2 * self.memory.settings_bytes * TICK_S
        return records_s / (1.0 - settings_s / FIRST_STEP_S) + SEEN_EVERY_S

    def stale(self, cut: firing.Cut) -> str:
        """Say it if the newest record is neither of the last state and segment nor just behind."""
        record = self.record(cut.image)
        known_s = cut.time_s - self.late_s()
        changed_s = _changed_s(cut, known_s)
        moments = [each for each in cut.seen if changed_s is None or each.time_s >= changed_s]
        known = record and record._replace(program_crc=0)
        matching = [each for each in moments if known in _made_of(cut, each)]
        if matching:
            running = record is not None and record.state in {firing.RUNNING, firing.RETURNING}
            age_s = cut.time_s - matching[-1].time_s
            if running and age_s > self.save_every_s + self.late_s():
                return f"the record is {age_s:.1f} s old"
            return ""
        if changed_s is None and record == cut.found:
            return ""  # nothing has been saved since the power came on
        return f"{record} is of no moment since {changed_s}"


def _made_of(cut: firing.Cut, moment: firing.Seen) -> Iterator[Progress]:
    """What a moment may be noted as: as it was, or as an order to stop or to pause will leave it.
    Such an order is noted at once, and obeyed by the next step; a cut may come before that."""
    now = moment.record
    yield now
    later = next((each.record for each in cut.seen if each.time_s > moment.time_s), None)
    if now.state != firing.IDLE and (later is None or later.state == firing.IDLE):
        yield now._replace(state=firing.IDLE, ended=STOPPED)
    if now.state in {firing.RUNNING, firing.RETURNING} and (
        later is None or later.state != now.state
    ):
        yield now._replace(state=firing.PAUSED)


def _changed_s(cut: firing.Cut, before_s: float) -> float | None:
    """When state or segment changed last before a time, since the power came on; None: never."""
    changed_s = None
    for (_, last), (time_s, record) in pairwise(cut.seen):
        if time_s > before_s:
            break
        if (record.state, record.segment) != (last.state, last.segment):
            changed_s = time_s
    return changed_s


class Outcome(NamedTuple):
    state: int
    ended: int
    goes_on: Progress | None
    loaded: Stored | None
    code: int


class Again(AvrDevice):
    """A controller that is powered up again and again, each time with another EEPROM."""

    def power_up(self, image: bytes, felt_c: float) -> None:
        self.power_cycle()
        self.avr.eeprom.contents = image
        self.sense(firing.LOOP, felt_c)

    def run(self, seconds: float) -> None:
        self.advance(self.time_s + seconds)

    def heated(self) -> bool:
        """Whether the heater's pin was active since the last call."""
        return self.on_fraction("element") > 0


class Judge:
    def __init__(self, controller: Controller, program: Elf) -> None:
        self.book = Book(controller)
        self._device = Again(controller, program)
        self.wanted = Outcome(firing.IDLE, 0, None, None, 0)  # what had to become of the last cut

    def problems(self, cut: firing.Cut, change_k: float) -> Iterator[str]:
        """Let the power come back with the machine hotter by so much, and say what is wrong."""
        stale = self.book.stale(cut)
        if stale:
            yield stale
        self._device.power_up(cut.image, max(LEAST_C, cut.felt_c + change_k))
        yield from self._start()
        wanted = self.wanted = self._wanted(cut.image)
        found_state, found_ended = self._read("state"), self._read("ended")
        if self._device.read("fault.code") != wanted.code:
            yield f"fault {self._device.read('fault.code')}, not {wanted.code}"
        if (found_state, found_ended) != (wanted.state, wanted.ended):
            yield f"state {found_state}, ended {found_ended}, not {wanted}"
        if wanted.goes_on is not None:
            yield from self._goes_on(wanted.goes_on, wanted.loaded)
        yield from self._settings(self.book.memory.settings(cut.image))
        if wanted.state in {firing.IDLE, firing.PAUSED, firing.INTERRUPTED}:
            self._device.run(WATCHED_S)
            if self._device.heated():
                yield "the heater is on though nothing runs"

    def _read(self, member: str) -> float:
        found: float = self._device.read(f"program.{member}").item()
        return found

    def _start(self) -> Iterator[str]:
        """Run to the first step; no heater may be on until what is to be done is decided."""
        device, steps = self._device, f"loop_{firing.LOOP}.steps"
        device.run(FIRST_STEP_S - 0.1)
        while device.read(steps) == 0 or self._read("state") == firing.RESTORING:
            if device.avr.time_s > DECIDED_BY_S:
                yield "nothing is decided"
                return
            self._device.run(SLICE_S)
        if device.heated():
            yield "the heater is on before the checks"

    def _wanted(self, image: bytes) -> Outcome:
        record, kept = self.book.record(image), self.book.memory.settings(image)
        code = kept.code if kept else 0
        if record is None or record.state == firing.IDLE:
            return Outcome(firing.IDLE, record.ended if record else 0, None, None, code)
        program = self.book.memory.program(image, record.number)
        if program is None or program.crc != record.program_crc:
            return Outcome(firing.IDLE, POWER_UNREADABLE, None, None, code)
        if not code and record.state != firing.INTERRUPTED:
            return self._decided(record, program)
        if not self.book.keeps:
            return Outcome(firing.IDLE, FAILED, None, None, code)
        state = firing.PAUSED if record.state == firing.PAUSED else firing.INTERRUPTED
        return Outcome(state, record.ended, record, program, code)

    def _decided(self, record: Progress, program: Stored) -> Outcome:
        """What becomes of a program that nothing but the power has stopped."""
        temperature_c = self._device.read(f"loop_{firing.LOOP}.temperature_c").item()
        cold = abs(temperature_c - record.temperature_c) > self.book.within_k
        if record.state == firing.PAUSED or (cold and self.book.pauses):
            return Outcome(firing.PAUSED, record.ended, record, program, 0)
        if cold:
            return Outcome(firing.IDLE, TOO_FAR, None, None, 0)
        return Outcome(firing.RETURNING, record.ended, record, program, 0)

    def _goes_on(self, record: Progress, program: Stored | None) -> Iterator[str]:
        for name in Progress._fields:
            if name in {"state", "program_crc", "temperature_c", "energy"}:
                continue
            if self._read(name) != getattr(record, name):
                yield f"{name} is {self._read(name)}, not {getattr(record, name)}"
        if not 0 <= self._read("energy") - record.energy <= FULL_PERMILLE:
            yield f"energy is {self._read('energy')}, not {record.energy}"
        first = self._device.variables["program.c:loaded"].address
        raw = self._device.avr.read_ram(first, 14 + 7 * self.book.memory.points)
        if (loaded := Stored.of(raw)) != program:
            yield f"{loaded} runs, not {program}"

    def _settings(self, kept: Settings | None) -> Iterator[str]:
        if kept is None:
            return
        values = dict(zip(("kp", "ki", "kd"), kept.gains, strict=True))
        values |= {"maximum_c": kept.maximum_c, "thermocouple": kept.type}
        for name, value in values.items():
            found = self._device.read(f"settings.{firing.LOOP}_{name}")
            if not np.array_equal(found, np.array(value, found.dtype)):
                yield f"{name} is {found}, not {value}"
