"""TIMSK belongs to all timers: who changes it must not undo what an interrupt did meanwhile."""

import pytest
from rig.firmware import Board, board_of, changed, part, sources_of
from rig.outputs import wired

from heatwright.sim.avr import Avr
from heatwright.sim.native.pins import pin_number

HEATER_SAID = "kind: pwm, pin: PC0, frequency: 500 Hz, power: 40 W"
SPEC = wired("atmega32", {"heater": HEATER_SAID}).text  # its thermometer is at PA1
GATE = pin_number("PC7")

MAIN = """
#include <avr/interrupt.h>
#include <avr/io.h>
#include "clock.h"
#include "gate.h"
#include "one_wire_air.h"
#include "output_heater.h"
#include "pins.h"

/* Every other tick the gate is closed; PC7 shows it. */
void gate_tick(void)
{
    PORTC ^= 0x80;
    output_heater_tick((PORTC & 0x80) != 0);
}

int main(void)
{
    DDRC |= 0x80;
    pin_output_heater_drive();
    output_heater_start();
    output_heater_set(50.0f);
    clock_start();
    sei();
    for (uint8_t pause = 0;; pause++) { /* over and over, at any time within a tick */
        pin_sensor_air_release();
        one_wire_air_exchange(0, 1);
        for (uint8_t left = pause & 63u; left != 0; left--) {
            __asm__ volatile("");
        }
    }
}
"""
GUARD = "ATOMIC_BLOCK(ATOMIC_RESTORESTATE)"
SECONDS = 10


def running(main: str, names: list[str], guarded_file: str, *, guarded: bool) -> Avr:
    """Return a processor with the tick and a main program, whose guard may be taken out."""
    bare = {guarded_file: changed(sources_of(SPEC)[guarded_file], (GUARD, ""))}
    program = part(SPEC, ["clock", *names], main, changed=None if guarded else bare)
    return Board(program, board_of(SPEC)).avr


@pytest.mark.parametrize("guarded", [True, False])
def test_a_closed_gate_stays_closed(guarded: bool) -> None:
    """Without the guard the heater's interrupt is now and then asked for again: seen to be so."""
    names = ["one_wire_air", "output_heater"]
    avr = running(MAIN, names, "one_wire_air.c", guarded=guarded)
    avr.pins.pull("PA1", "high")
    for pin in ("PC0", "PC7"):
        avr.pins.watch(pin)
    avr.run(SECONDS)
    is_open, behind, pulses = False, 0, 0
    for event in avr.pins.take():
        high = bool(event["state"] & 1)
        if event["pin"] == GATE:
            is_open = high
        elif high:
            pulses += 1
            behind += not is_open
    assert pulses > 0.9 * SECONDS * 500 / 2
    assert (behind == 0) == guarded


STARTER = """
#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdbool.h>
#include "clock.h"
#include "gate.h"

static volatile bool asked;

void gate_tick(void) {}

EMPTY_INTERRUPT(TIMER0_COMP_vect)

/* As a byte does that the line receives: it asks for the end of the silence behind it. */
ISR(TIMER1_COMPA_vect)
{
    TIMSK |= (1u << OCIE0);
    asked = true;
}

/* PC7 shows that this was undone. */
int main(void)
{
    DDRC |= 0x80;
    OCR1A = 210; /* 211 cycles, a prime: it strikes anywhere in the loop */
    TCCR1B = (1u << WGM12) | (1u << CS10);
    TIMSK = (1u << OCIE1A);
    sei();
    for (;;) {
        clock_start();
        cli();
        if (asked && !(TIMSK & (1u << OCIE0))) {
            PORTC |= 0x80;
        }
        PORTC &= (uint8_t)~0x80;
        TIMSK &= (uint8_t)~(1u << OCIE0);
        asked = false;
        sei();
    }
}
"""


@pytest.mark.parametrize("guarded", [True, False])
def test_the_tick_begins_without_undoing_what_an_interrupt_asked_for(guarded: bool) -> None:
    """Interrupts are on by then, and the line listens: a frame would have no end."""
    avr = running(STARTER, [], "clock.c", guarded=guarded)
    avr.pins.watch("PC7")
    avr.run(1)
    undone = sum(bool(event["state"] & 1) for event in avr.pins.take())
    assert (undone == 0) == guarded
