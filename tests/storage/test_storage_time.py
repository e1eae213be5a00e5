"""Nothing waits for the EEPROM: it is read and written when it is ready, and only then."""

import pytest
from rig.firmware import Board, Program, board_of
from storage_firing import Firing, FiringByKeys, machine
from storage_specs import text_of
from storage_verdict import Book

from heatwright.sim.binary.elf import Elf

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
MOST_S = 500e-6
"""A byte takes 3.3 ms to write; a record is made, and its CRC, in much less."""


def waiting(machine: str) -> Program:
    return Program(text_of(machine), FILES, MAIN)


def waits_problem(machine: str, elf: Elf) -> str:
    """Say that not everything is written, or that something waits for the EEPROM."""
    board = Board(elf, board_of(text_of(machine)))
    board.avr.run(RUN_S)
    if board.avr.eeprom.writes < LEAST_BYTES or board.avr.eeprom.violations:
        return f"{board.avr.eeprom.writes} bytes are written in {RUN_S} s"
    longest_s = int(board.get("longest")) / board.avr.clock_hz
    return f"a tick takes {longest_s * 1e6:.0f} µs" if longest_s > MOST_S else ""


@pytest.mark.parametrize("machine", ["few", "typed"])
def test_nor_where_all_want_to_write_at_once(machine):
    assert waits_problem(machine, waiting(machine).elf()) == ""
