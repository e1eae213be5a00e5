"""Small firmware, compiled for the tests of the simulator."""

import hashlib
import subprocess
import tempfile
from functools import cache
from pathlib import Path

from heatwright.sim.avr import Avr
from heatwright.sim.elf import Elf

CLOCK_HZ = 16_000_000
SHARED = Path(__file__).parent / "sim_native" / "firmware"
PRELUDE = """
#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <stdbool.h>
#include <stdint.h>
#include <util/delay.h>
"""


@cache
def _folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="avr-firmware-"))


def compiled(source: str, *flags: str, mcu: str = "atmega328p") -> Elf:
    """Compile C; the usual headers are included."""
    command = ["avr-gcc", f"-mmcu={mcu}", f"-DF_CPU={CLOCK_HZ}UL", "-Os"]
    command += [] if any(flag.startswith("-g") for flag in flags) else ["-gdwarf-2"]
    command += ["-std=gnu11", "-Wall", "-Wno-unused-function", *flags, "-x", "c"]
    name = hashlib.sha256(repr((command, source)).encode()).hexdigest()[:16]
    path = _folder() / f"{name}.elf"
    if not path.exists():
        text = f'{PRELUDE}\n#line 1 "test.c"\n{source}'
        subprocess.run([*command, "-o", path, "-"], input=text, text=True, check=True)
    return Elf(path)


def shared(name: str, *flags: str, mcu: str = "atmega328p") -> Elf:
    """Compile one of the files in tests/sim_native/firmware."""
    return compiled((SHARED / name).read_text(), *flags, mcu=mcu)


def powered(program: Elf, mcu: str = "atmega328p") -> Avr:
    """A processor with the program, at cycle 0."""
    avr = Avr(mcu, CLOCK_HZ)
    avr.load(program)
    return avr


def running(source: str, *flags: str, mcu: str = "atmega328p") -> Avr:
    """A processor at cycle 0 with this C as its program."""
    return powered(compiled(source, *flags, mcu=mcu), mcu)
