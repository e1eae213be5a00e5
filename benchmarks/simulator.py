"""How fast the simulated processor runs, in multiples of real time.

    .venv/bin/python benchmarks/simulator.py

Each program is run by the shim's instruction core and by simavr's. Times are of the processor, not
of the clock on the wall, and the best of three, so a busy machine does not show much.
"""

from __future__ import annotations

import subprocess
import tempfile
import time
from pathlib import Path

from heatwright.sim.avr import Avr
from heatwright.sim.elf import Elf

CLOCK_HZ = 16_000_000
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
PROGRAMS = {
    "never sleeps": (BUSY, [], 5),
    "sleeps, 1 kHz tick": (TICK, ["-DRATE=1000", "-DWORK=;"], 100),
    "sleeps, 100 Hz tick": (TICK, ["-DRATE=100", "-DWORK=;"], 1000),
    "sleeps, floats at 1 kHz": (TICK, ["-DRATE=1000", f"-DWORK={FLOATS}"], 50),
}


def compiled(source: str, flags: list[str], folder: str) -> Elf:
    """Compile a program for an ATmega328P."""
    path = Path(folder) / "program.elf"
    command = ["avr-gcc", "-mmcu=atmega328p", "-Os", "-std=gnu11", *flags, "-x", "c", "-"]
    text = f"#include <avr/io.h>\n{source}"
    subprocess.run([*command, "-o", path], input=text, text=True, check=True)  # noqa: S603
    return Elf(path)


def speed(program: Elf, seconds: float, *, simavrs_core: bool) -> float:
    """Return simulated by processor time, the best of three."""
    best = 0.0
    for _ in range(3):
        avr = Avr("atmega328p", CLOCK_HZ)
        avr.load(program)
        if simavrs_core:
            avr.use_simavrs_core()
        start = time.process_time()
        avr.run(seconds)
        best = max(best, seconds / (time.process_time() - start))
    return best


def main() -> None:
    """Print a row for each program."""
    print(f"{'program':26}{'times real time':>16}{'with simavr’s core':>20}")
    with tempfile.TemporaryDirectory() as folder:
        for name, (source, flags, seconds) in PROGRAMS.items():
            program = compiled(source, flags, folder)
            ours = speed(program, seconds, simavrs_core=False)
            simavrs = speed(program, seconds, simavrs_core=True)
            print(f"{name:26}{ours:16.0f}{simavrs:20.0f}")


if __name__ == "__main__":
    main()
