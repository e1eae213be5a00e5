# SPDX-License-Identifier: GPL-3.0-or-later
"""The simulated processor alone: the same image here, in plain simavr, and in avr8js.

Plain simavr is libsimavr's own loop, `avr_run`, in a program of C that does nothing else. avr8js
takes SLEEP for NOP; here its time goes on to what happens next, as a program that uses it would.
Nothing is wired to the pins. Each tells the processor time of its loop; starting is no part of it.
"""

from __future__ import annotations

import base64
import json
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory
from typing import Any

from loop import Silent
from measure import EXAMPLES, JUDGES, Tell

from heatwright.cli.firmware import build_firmware
from heatwright.sim.avr import Avr
from heatwright.sim.binary.elf import Elf
from heatwright.spec import load

MCU, CLOCK_HZ, FLASH_BYTES = "atmega328p", 16_000_000, 32768
HERE = Path(__file__).parent
AVR8JS = JUDGES / "node_modules" / "avr8js"

TICK = """
#include <avr/interrupt.h>
#include <avr/sleep.h>
volatile unsigned char ticks;
ISR(TIMER1_COMPA_vect) { ticks++; }
int main(void) {
    TCCR1B = _BV(WGM12) | _BV(CS11);
    OCR1A = 2000000UL / RATE - 1;
    TIMSK1 = _BV(OCIE1A);
    sleep_enable();
    sei();
    for (;;) { sleep_cpu(); WORK }
}
"""
FLOATS = "static volatile float x; x = x * 0.99f + ticks * 0.5f; x = x / 3.0f;"
BUSY = """
#include <stdint.h>
int main(void) { volatile uint32_t x = 1; for (;;) x = x * 1664525UL + 1013904223UL; }
"""
PROGRAMS: dict[str, tuple[str, tuple[str, ...], float]] = {
    "never sleeps": (BUSY, (), 2),
    "sleeps, 1 kHz tick": (TICK, ("-DRATE=1000", "-DWORK=;"), 50),
    "sleeps, 100 Hz tick": (TICK, ("-DRATE=100", "-DWORK=;"), 500),
    "sleeps, floats at 1 kHz": (TICK, ("-DRATE=1000", f"-DWORK={FLOATS}"), 20),
}
"""By name: source, what is defined for it, simulated seconds."""
FIRMWARE = "the chamber's firmware"
FIRMWARE_S = 100.0
ENOUGH_S = 5.0
"""Simulated time that is enough for avr8js, whose speed does not depend on the program: its timers
count one by one, also while the processor sleeps."""


def cores(times: int, tell: Tell, share: float) -> dict[str, Any]:
    """Run all images on all simulators, in turns; `share`: of the usual simulated time."""
    found: dict[str, Any] = {}
    with TemporaryDirectory() as parent:
        folder = Path(parent)
        simulators = available(folder)
        for name, (elf, seconds) in images(folder).items():
            tell(f"the processor: {name}")
            best = dict.fromkeys(simulators, 0.0)
            for _ in range(times):
                for each, run in simulators.items():
                    best[each] = max(best[each], run(elf, share * seconds))
            found[name] = best
    return found


def images(folder: Path) -> dict[str, tuple[Path, float]]:
    """Compile the programs; return each binary and how long it is to run, s."""
    found = {}
    for number, (name, (source, flags, seconds)) in enumerate(PROGRAMS.items()):
        elf = folder / f"{number}.elf"
        command = ["avr-gcc", f"-mmcu={MCU}", "-Os", "-std=gnu11", *flags, "-x", "c", "-"]
        text = f"#include <avr/io.h>\n{source}"
        subprocess.run([*command, "-o", elf], input=text, text=True, check=True)  # noqa: S603
        found[name] = (elf, seconds)
    firmware = build_firmware(load(EXAMPLES / "chamber.yaml"), Silent()).elf
    return found | {FIRMWARE: (firmware, FIRMWARE_S)}


def available(folder: Path) -> dict[str, Callable[[Path, float], float]]:
    """Return the simulators that are there: each runs a binary so long, and tells its speed."""
    found: dict[str, Callable[[Path, float], float]] = {
        "heatwright": ours,
        "heatwright --core simavr": lambda elf, seconds: ours(elf, seconds, simavrs_core=True),
    }
    try:
        found["simavr"] = simavr(folder)
    except (OSError, subprocess.CalledProcessError) as error:
        print(f"  without plain simavr: nothing can be linked with libsimavr ({error})")
    if which("node") and AVR8JS.exists():
        found["avr8js"] = avr8js
    else:
        print(f"  without avr8js: node or {AVR8JS} is missing (make peers installs them)")
    return found


def ours(elf: Path, seconds: float, *, simavrs_core: bool = False) -> float:
    """Run a binary on the product's processor."""
    avr = Avr(MCU, CLOCK_HZ)
    avr.load(Elf(elf))
    if simavrs_core:
        avr.use_simavrs_core()
    start = time.process_time()
    avr.run(seconds)
    return seconds / (time.process_time() - start)


def simavr(folder: Path) -> Callable[[Path, float], float]:
    """Compile the loop around libsimavr."""
    program = folder / "plain_simavr"
    source = HERE / "plain_simavr.c"
    subprocess.run(  # noqa: S603
        ["cc", "-O2", "-o", program, source, "-lsimavr"],  # noqa: S607
        check=True,
        capture_output=True,
    )

    def run(elf: Path, seconds: float) -> float:
        cycles = str(round(seconds * CLOCK_HZ))
        lines = told(program, elf, MCU, str(CLOCK_HZ), cycles)  # those of the ELF first
        return seconds / float(lines.split()[-1])

    return run


def avr8js(elf: Path, seconds: float) -> float:
    """Run a binary on avr8js, no longer than it takes to be quick."""
    seconds = min(seconds, ENOUGH_S)
    flash = Elf(elf).flash.ljust(FLASH_BYTES, b"\xff")
    asked = {
        "module": str(AVR8JS),
        "flash": base64.b64encode(flash).decode(),
        "clock_hz": CLOCK_HZ,
        "cycles": round(seconds * CLOCK_HZ),
    }
    return seconds / float(told("node", HERE / "avr8js.cjs", given=json.dumps(asked)))


def told(*command: str | Path, given: str = "") -> str:
    """Return what a program prints on its standard output."""
    done = subprocess.run(command, input=given, capture_output=True, text=True, check=True)  # noqa: S603
    return done.stdout
