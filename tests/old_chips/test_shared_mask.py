"""TIMSK belongs to all timers: who changes it must not undo what an interrupt did meanwhile."""

import subprocess
from pathlib import Path

import pytest

from heatwright.generator import plan_firmware, render
from heatwright.sim.avr import Avr
from heatwright.sim.elf import Elf
from heatwright.sim.native.pins import pin_number
from heatwright.spec import load_text

SPEC = """
heatwright: 1
controller: {name: masks, board: atmega32}
sensors: {air: {kind: ds18b20, pin: PA1}}
outputs: {heater: {kind: pwm, pin: PC0, frequency: 500 Hz, power: 40 W}}
loops:
  air:
    sensor: air
    heater: heater
    period: 1 s
    setpoint: {initial: 0 °C, minimum: 0 °C, maximum: 70 °C}
    algorithm: {kind: pid, kp: 10, ki: 0.1}
"""
HEATER, GATE = pin_number("PC0"), pin_number("PC7")

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
        one_wire_air_exchange(1);
        for (uint8_t left = pause & 15u; left != 0; left--) {
            __asm__ volatile("");
        }
    }
}
"""
GUARD = "ATOMIC_BLOCK(ATOMIC_RESTORESTATE) /* TIMSK belongs to all timers */"
SECONDS = 10


def simulated(folder: Path, texts: dict[str, str], sources: list[str]) -> Avr:
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    chip = ["-mmcu=atmega32", "-DF_CPU=16000000UL", "-Os", "-std=c11", "-gdwarf-2"]
    command = ["avr-gcc", *chip, *sources, "-o", "masks.elf"]
    subprocess.run(command, cwd=folder, check=True)
    avr = Avr("atmega32", 16_000_000)
    avr.load(Elf(folder / "masks.elf"))
    return avr


def pulses_behind_the_gate(folder: Path, *, guarded: bool) -> int:
    files = render(plan_firmware(load_text(SPEC, "masks.yaml")))
    texts = {path.removeprefix("src/"): text for path, text in files.items() if "src/" in path}
    assert texts["one_wire_air.c"].count(GUARD) == 1
    if not guarded:
        texts["one_wire_air.c"] = texts["one_wire_air.c"].replace(GUARD, "")
    sources = ["main.c", "clock.c", "one_wire_air.c", "output_heater.c"]
    avr = simulated(folder, {**texts, "main.c": MAIN}, sources)
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
    return behind


@pytest.mark.parametrize("guarded", [True, False])
def test_a_closed_gate_stays_closed(guarded: bool, tmp_path: Path) -> None:
    """Without the guard the heater's interrupt is now and then asked for again: seen to be so."""
    assert (pulses_behind_the_gate(tmp_path, guarded=guarded) == 0) == guarded


STARTER = """
#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdbool.h>
#include "clock.h"
#include "gate.h"

static volatile bool asked;

void gate_tick(void)
{
}

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


def undone_by_the_clock(folder: Path, *, guarded: bool) -> int:
    files = render(plan_firmware(load_text(SPEC, "masks.yaml")))
    texts = {path.removeprefix("src/"): text for path, text in files.items() if "src/" in path}
    assert texts["clock.c"].count(GUARD) == 1
    if not guarded:
        texts["clock.c"] = texts["clock.c"].replace(GUARD, "")
    avr = simulated(folder, {**texts, "main.c": STARTER}, ["main.c", "clock.c"])
    avr.pins.watch("PC7")
    avr.run(1)
    return sum(bool(event["state"] & 1) for event in avr.pins.take())


@pytest.mark.parametrize("guarded", [True, False])
def test_the_tick_begins_without_undoing_what_an_interrupt_asked_for(
    guarded: bool, tmp_path: Path
) -> None:
    """Interrupts are on by then, and the line listens: a frame would have no end."""
    assert (undone_by_the_clock(tmp_path, guarded=guarded) == 0) == guarded
