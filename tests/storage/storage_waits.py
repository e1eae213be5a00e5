"""What writes, in a processor of its own: how long a tick of it takes at most."""

from rig.avr import Board, Program, board_of
from storage_specs import text_of

from heatwright.sim.elf import Elf

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
