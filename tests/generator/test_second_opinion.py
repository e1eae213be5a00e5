"""Second opinions on the generated C: the Arduino IDE builds the folder as a sketch, with its own
flags and core and our main; cppcheck finds nothing."""

import re
import shutil
import subprocess
from pathlib import Path
from random import Random

import pytest
from rig.controllers import drawings
from rig.specs import example, files_of
from suite import SEED, amount

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.plan.assembly import MCU_MACROS
from heatwright.spec import Spec

IDE = Path("/usr/share/arduino/hardware/arduino/avr")
"""Where Debian's arduino-core-avr puts it."""

SLOW = {"-flto", "-fno-fat-lto-objects", "-fuse-linker-plugin"}
"""Link-time optimisation, which older IDEs do without."""


def flags(language: str, lto: bool) -> list[str]:
    """Return what platform.txt gives the compiler; every warning an error."""
    text = (IDE / "platform.txt").read_text()
    found = re.search(rf"^compiler\.{re.escape(language)}\.flags=(.*)$", text, re.MULTILINE)
    assert found is not None
    words = found[1].replace("{compiler.warning_flags}", "-Wall -Wextra").split()
    return [word for word in words if lto or word not in SLOW]


def run(*command: str | Path, cwd: Path) -> str:
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def core(folder: Path, lto: bool, where: list[str]) -> Path:
    """Compile the core of the IDE into an archive."""
    folder.mkdir()
    for language, compiler in (("c", "avr-gcc"), ("cpp", "avr-g++")):
        chosen = sorted((IDE / "cores" / "arduino").glob(f"*.{language}"))
        # gcc 5.4 keeps this one from C++; the IDE's own compiler is newer.
        words = [*flags(language, lto), "-w", "-DDECIMAL_DIG=__DECIMAL_DIG__"]
        run(compiler, *words, *where, *chosen, cwd=folder)
    run("avr-gcc-ar", "rcs", "core.a", *sorted(folder.glob("*.o")), cwd=folder)
    return folder / "core.a"


@pytest.mark.parametrize("lto", [True, False], ids=["lto", "plain"])
def test_the_ide_builds_the_chamber(lto: bool, tmp_path: Path) -> None:
    chamber_files = files_of("chamber")
    write(chamber_files, tmp_path / "chamber")
    sources = sorted((tmp_path / "chamber" / "src").glob("*.c"))
    where = [
        "-mmcu=atmega328p", "-DF_CPU=16000000L", "-DARDUINO=10819", "-DARDUINO_AVR_UNO",
        "-DARDUINO_ARCH_AVR", f"-I{IDE}/cores/arduino", f"-I{IDE}/variants/standard",
    ]  # fmt: skip
    archive = core(tmp_path / "core", lto, where)
    # The IDE puts Arduino.h in front of the sketch and compiles it as C++.
    sketch = tmp_path / "chamber.ino.cpp"
    sketch.write_text(f"#include <Arduino.h>\n{chamber_files['chamber.ino']}", encoding="utf-8")
    ours = tmp_path / "objects"
    ours.mkdir()
    run("avr-gcc", *flags("c", lto), "-Werror", *where, *sources, cwd=ours)
    run("avr-g++", *flags("cpp", lto), "-Werror", *where, sketch, cwd=ours)
    run(
        "avr-gcc", *flags("c.elf", lto), "-Werror", "-mmcu=atmega328p", "-o", "chamber.elf",
        *sorted(ours.glob("*.o")), archive, "-lm", "-Wl,-Map=chamber.map", cwd=tmp_path,
    )  # fmt: skip
    assert "core.a(" not in (tmp_path / "chamber.map").read_text().partition("Allocating")[0]
    listing = run("avr-objdump", "-d", "chamber.elf", cwd=tmp_path)
    assert_starts_safely(listing)
    size = run("avr-size", "chamber.elf", cwd=tmp_path)
    print(f"\nArduino IDE, {'with' if lto else 'without'} -flto:\n{size}")


def assert_starts_safely(listing: str) -> None:
    """The reset leads to heaters_off: D3 = PD3 low and driven before there is a stack."""
    first = re.search(r"^ +0:\t(?:\w\w )+\s*jmp\t0x(\w+)", listing, re.MULTILINE)
    assert first is not None
    start = re.search(rf"^0*{first[1]} <heaters_off>:\n(.*\n)(.*\n)", listing, re.MULTILINE)
    assert start is not None
    assert "cbi\t0x0b, 3" in start[1]
    assert "sbi\t0x0a, 3" in start[2]


CPPCHECK = [
    "cppcheck", "--quiet", "--enable=warning,performance,portability", "--inconclusive",
    "--std=c11", "--platform=avr8", "--library=avr", "--error-exitcode=1",
]  # fmt: skip


def assert_nothing_is_found(spec: Spec, folder: Path) -> None:
    board = spec.controller.board
    write(render(plan_firmware(spec)), folder)
    assert shutil.which("cppcheck"), "sudo apt-get install cppcheck"
    done = subprocess.run(
        [*CPPCHECK, f"-D{MCU_MACROS[board.mcu]}", f"-DF_CPU={board.clock_hz}UL", "src"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("name", ["chamber", "fabricator", "dryer", "kiln", "kiln_uno"])
def test_nothing_is_found_in_examples(name: str, tmp_path: Path) -> None:
    assert_nothing_is_found(example(name), tmp_path)


@pytest.mark.parametrize("number", range(amount("drawn_for_cppcheck")))
def test_nothing_is_found_in_what_is_drawn(number: int, tmp_path: Path) -> None:
    random = Random(f"cppcheck {SEED} {number}")  # noqa: S311 - no secret
    assert_nothing_is_found(next(iter(drawings(random))).spec, tmp_path)
