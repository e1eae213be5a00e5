"""The EEPROM: where everything stands in it, that nothing waits for it, what a power cut leaves. It
is read and written when it is ready, and only then. Ten thousand power cuts are on the kilns'
binaries, while they fire, are ordered about and save."""

import re
from collections import Counter
from itertools import islice, pairwise, product
from random import Random
from typing import NamedTuple

import pytest
from rig.firmware import ROOT, Board, Program, board_of, files_of, spec_of
from storage_firing import Firing, FiringByKeys, machine
from storage_format import PROGRESS_BYTES, Memory, Progress
from storage_specs import NAMES, board_text, text_of
from storage_verdict import FIRST_STEP_S, Again, Book, Judge, Outcome
from suite import amount

from heatwright.sim.binary.elf import Elf
from heatwright.sim.faults.bounds import checks_s
from heatwright.spec import Controller, SpecError, load_text
from heatwright.spec.board.eeprom import CELL_WRITES, YEAR_S, layout, settings_bytes, start_s

BOARDS = ("uno", "leonardo", "mega2560")
FEWEST_SETTINGS, MOST_SETTINGS = 4, 16


@pytest.mark.parametrize("name", NAMES)
def test_the_firmware_has_the_same_layout(name):
    controller = spec_of(text_of(name)).controller
    areas, memory = layout(controller), Memory(controller)
    config = files_of(text_of(name))["src/config.h"]
    found = {key: int(n) for key, n in re.findall(r"#define (\w+_(?:EEPROM|SLOTS)) (\d+)u", config)}
    assert found == {
        "SETTINGS_SLOTS": areas.settings.slots, "PROGRAMS_EEPROM": areas.programs.start,
        "PROGRESS_EEPROM": areas.progress.start, "PROGRESS_SLOTS": areas.progress.slots,
    }  # fmt: skip
    assert areas.programs.slot_bytes == memory.program_bytes
    assert areas.progress.slot_bytes == PROGRESS_BYTES
    assert settings_bytes(controller) == memory.settings_bytes


def tried(board: str, programs: str) -> tuple[Controller | None, str]:
    """The controller, or why it is refused."""
    try:
        return load_text(board_text(board, programs), "tried.yaml").controller, ""
    except SpecError as error:
        return None, str(error)


SIZES = list(product(BOARDS, (3, 10, 20), (2, 3, 8), ("10 s", "1 min", "7 min", "1 h")))
PROGRAMS = "  points: {}\n  places: {}\n  save_every: {}"


def test_whatever_is_accepted_fits_and_lasts_ten_years():
    controllers = [tried(size[0], PROGRAMS.format(*size[1:]))[0] for size in SIZES]
    accepted = [each for each in controllers if each is not None]
    assert len(accepted) > len(SIZES) // 4
    for controller in accepted:
        areas, room = layout(controller), controller.board.eeprom_bytes
        assert areas.settings.start == 0
        assert all(one.end == other.start for one, other in pairwise(areas))
        assert areas.end <= room
        assert FEWEST_SETTINGS <= areas.settings.slots <= MOST_SETTINGS
        every_s = controller.programs.save_every_s
        assert areas.progress.slots * CELL_WRITES * every_s >= 10 * YEAR_S
        assert areas.progress.slots <= 255
        assert room - areas.end < PROGRESS_BYTES or areas.progress.slots == 255


def test_what_is_proposed_where_something_is_refused_is_accepted():
    proposals = 0
    for board, points, places, every in SIZES:
        controller, why = tried(board, PROGRAMS.format(points, places, every))
        proposed = re.search(r"Use save_every: ([^,.]+), or", why)
        if proposed:
            proposals += 1
            assert tried(board, PROGRAMS.format(points, places, proposed[1]))[1] == ""
        elif controller is None:
            assert "bytes, and the EEPROM of the" in why
    assert proposals > len(SIZES) // 4


@pytest.mark.parametrize(("board", "every"), [("mega2560", "1 min"), ("uno", "11 min")])
def test_the_page_says_how_long_it_lasts(board, every):
    page = (ROOT / "docs" / "storage.md").read_text(encoding="utf-8")
    programs = f"  save_every: {every}"
    controller = load_text(board_text(board, programs), "page.yaml").controller
    areas = layout(controller)
    years = areas.progress.years(controller.programs.save_every_s)
    words = f"{areas.settings.slots} slots of settings, {areas.progress.slots} of progress: "
    assert f"{words}{int(years * 10) / 10:.1f} years" in page
    assert f"`save_every: {every}`" in page
    assert f"{areas.programs.slot_bytes - 70} bytes, and 7 for each of `points`" in page
    assert f"| {areas.progress.slot_bytes} bytes |" in page


ROWS = 1500
WAIT_S = 100e-6
TICK_S = 0.01
ACCESS = ("eeprom_read_byte", "eeprom_write_byte")


@pytest.mark.parametrize(("example", "firing_of"), [("kiln", Firing), ("kiln_uno", FiringByKeys)])
def test_no_access_waits_for_another(example, firing_of, monkeypatch):
    controller, program = machine(example)
    firing = firing_of(controller, program, 5, Book(controller).record)
    monkeypatch.setattr(firing, "lose_power", lambda: None)  # a profile is of one processor
    avr = firing.device.avr
    profile = avr.profile(program)
    for row in range(ROWS):
        list(firing.cuts(1, busy=0.0, quiet=0.0))
        if example == "kiln" and row % 3 == 0:
            firing.device.send(f"#13 {1 + row % 9 // 3};")
    functions = profile.functions
    assert avr.eeprom.writes > 300
    assert avr.eeprom.violations == 0
    for name in ACCESS:
        assert functions[name].calls > 300
        assert functions[name].longest < WAIT_S * avr.clock_hz
    longest = {name: functions[name].longest for name in ("progress_tick", "programs_tick")}
    assert max(longest.values()) < TICK_S / 10 * avr.clock_hz


# ---- what writes, in a processor of its own: how long a tick of it takes at most ----

FILES = ("programs", "progress", "settings")
MAIN = r"""
#include <avr/io.h>
#include <string.h>
#include "fault.h"
#include "program.h"
#include "programs.h"
#include "progress.h"
#include "settings.h"

struct fault_state fault;
volatile uint16_t longest;
static struct stored_program stored = { .name = "one", .segments = 1,
                                        .segment = { { PROGRAM_UNTIL, 0, 0 } } };

void fault_trip(uint8_t code, float temperature_c) { (void)code; (void)temperature_c; }
void fault_restore(const struct fault_state *latched) { fault = *latched; }
void program_note(struct progress_record *record) { memset(record, 1, sizeof *record); }

int main(void)
{
    TCCR1B = 1u << CS10;
    settings_start();
    programs_write(1, &stored);
    progress_save();
    settings_save();
    for (;;) {
        const uint16_t began = TCNT1;
        settings_tick();
        progress_tick();
        programs_tick();
        const uint16_t taken = (uint16_t)(TCNT1 - began);
        longest = taken > longest ? taken : longest;
    }
}
"""
RUN_S = 1.0
LEAST_BYTES = 110
MOST_S = 500e-6  # a byte takes 3.3 ms to write; a record is made, and its CRC, in much less


def waiting(machine: str) -> Program:
    return Program(text_of(machine), FILES, MAIN)


def waits_problem(machine: str, elf: Elf) -> str:
    board = Board(elf, board_of(text_of(machine)))
    board.avr.run(RUN_S)
    if board.avr.eeprom.writes < LEAST_BYTES or board.avr.eeprom.violations:
        return f"{board.avr.eeprom.writes} bytes are written in {RUN_S} s"
    longest_s = int(board.get("longest")) / board.avr.clock_hz
    return f"a tick takes {longest_s * 1e6:.0f} µs" if longest_s > MOST_S else ""


@pytest.mark.parametrize("machine", ["few", "typed"])
def test_nor_where_all_want_to_write_at_once(machine):
    assert waits_problem(machine, waiting(machine).elf()) == ""


SEEDS = range(24)
CUTS = amount("power_cuts") // len(SEEDS)  # in each of the firings
MOST_ROWS = 20_000
RESOLUTION_S = 0.0002
CHANGES_K = (0.0, 20.0, -20.0, 45.0, -45.0)
"""Changes of temperature while the power is away: within 30 K, where it goes on, or beyond."""
COMMON, RARE = (
    {"torn", "idle", "goes on"},
    {"cold", "unreadable", "failed", "interrupted", "paused"},
)
ENOUGH = 400  # cuts in a firing, and it comes by all that is common and something of what is rare


def kind_of(outcome: Outcome) -> str:
    by_end = {3: "failed", 4: "cold", 5: "unreadable"}
    names = {
        (0, False): by_end.get(outcome.ended, "idle"),
        (2, True): "paused",
        (5, True): "interrupted",
    }
    return names.get((outcome.state, outcome.goes_on is not None), "goes on")


class Kiln(NamedTuple):
    controller: Controller
    program: Elf
    judge: Judge
    firing: type[Firing]


@pytest.fixture(scope="session")
def kilns() -> list[Kiln]:
    """The kiln that stops when it is too cold, one that is paused, and the one with keys, whose
    programs a fault ends; those of the others it interrupts."""
    made = [machine(), machine(otherwise="pause"), machine("kiln_uno")]
    touched, pausing, keyed = (
        Kiln(*each, Judge(*each), firing)
        for each, firing in zip(made, (Firing, Firing, FiringByKeys), strict=True)
    )
    return [touched, touched, pausing, keyed]


@pytest.mark.parametrize("seed", SEEDS)
def test_every_cut_leaves_what_can_go_on_or_has_ended(kilns, seed):
    random, found = Random(seed), []  # noqa: S311
    controller, program, judge, firing_of = kilns[seed % len(kilns)]
    firing = firing_of(controller, program, seed, judge.book.record)
    # Most of them while something is written, the others as it comes.
    cuts = list(islice(firing.cuts(MOST_ROWS, busy=1.0, quiet=0.02), CUTS))
    assert len(cuts) == CUTS
    if firing_of is Firing:  # who plays with keys may change a program
        assert judge.book.forgotten(cuts, firing.edits) == ""
    tally: Counter[str] = Counter()
    for cut in cuts:
        problems = judge.problems(cut, random.choice(CHANGES_K))
        found += [f"{cut.time_s:.6f} s: {problem}" for problem in problems]
        tally[kind_of(judge.wanted)] += 1
        tally["torn"] += cut.torn
    assert found == []
    seen = set(+tally)
    assert CUTS < ENOUGH or (seen >= COMMON and seen & RARE)


def test_the_start_takes_no_longer_than_the_watchdog_is_told(kilns):
    """Every slot is written, so that each must be looked at: the first step comes so much later."""
    controller, program, judge, _ = kilns[0]
    memory = judge.book.memory
    record = Progress(0, 1, 1, 1, 0, 20.0, 20.0, 20.0, 20.0, 0, 0, 0, 0)
    slots = [
        (memory.progress_at + slot * PROGRESS_BYTES, memory.progress_slot(slot + 1, record))
        for slot in range(memory.progress_slots)
    ]
    device = Again(controller, program)
    for image in (memory.blank, memory.with_at(memory.blank, *slots)):
        device.power_up(image, 20.0)
        device.run(FIRST_STEP_S)
        while device.read("loop_chamber.steps") == 0:
            device.run(RESOLUTION_S)
        assert device.avr.time_s - FIRST_STEP_S < start_s(controller) + checks_s(
            controller, program
        )
