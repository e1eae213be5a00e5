"""What compiles whatever a spec says: any name, another crystal; and what must not. Second
opinions: the Arduino IDE builds the folder as a sketch, with its own flags and core and our main;
cppcheck finds nothing."""

import re
import shutil
import subprocess
from pathlib import Path
from random import Random

import pytest
from jinja2 import UndefinedError
from rig.controllers import drawings
from rig.firmware import changed, controller_of, example, files_of, whole
from suite import SEED, amount

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.plan import File, Plan
from heatwright.spec.names import LONGEST_NAME

PLAIN = changed("chamber").partition("simulation:")[0]


def test_an_undefined_name_is_an_error() -> None:
    file = File("src/clock.c", "core/clock.c.j2", {"tick_ms": 10})
    with pytest.raises(UndefinedError, match="'timer' is undefined"):
        render(Plan("name", "banner", (file,)))


@pytest.mark.parametrize("name", ["ticks", "fault", "i_2", "w" * LONGEST_NAME])
def test_a_name_may_be_any_word_of_the_firmware(name: str) -> None:
    """One name for sensor, output and loop at once, and one the firmware uses itself."""
    text = changed(PLAIN, ("maximum: 70 °C}", "maximum: 70 °C, stored: true}"))
    whole(re.sub(r"\bair\b|(?<=: )heater|heater(?=: {)", name, text))


@pytest.mark.parametrize("clock_mhz", [8, 14.7456, 20])
def test_another_crystal(clock_mhz: float) -> None:
    """PlatformIO is told of it, and no other clock compiles: every time would be wrong."""
    text = changed("chamber", ("board: uno", f"board: uno\n  clock: {clock_mhz} MHz"))
    text = text.partition("interfaces:")[0]
    clock_hz = controller_of(text).board.clock_hz
    assert "f_cpu" not in files_of("chamber")["platformio.ini"]
    assert clock_hz == round(clock_mhz * 1e6)
    assert f"\nboard_build.f_cpu = {clock_hz}L\n" in files_of(text)["platformio.ini"]
    whole(text)
    with pytest.raises(AssertionError, match=f"generated for a {clock_mhz:g} MHz clock"):
        whole(text, "-UF_CPU", "-DF_CPU=16000000UL")
    with pytest.raises(AssertionError, match="choose that board"):
        whole(text, "-U__AVR_ATmega328P__")


def test_as_many_periods_as_can_be_counted_are_taken_as_the_file_says_them() -> None:
    """0.83 · 255 is a little less than 211.65 in binary, and 70.2 − 10.3 than 59.9."""
    text = changed(
        PLAIN, ("period: 1 s", "period: 0.83 s"), ("stale_after: 5 s", "stale_after: 211.65 s"),
        ("minimum: 10 °C, maximum: 70 °C", "minimum: 10.3 °C, maximum: 70.2 °C"),
        ("step: 10 K", "step: 59.9 K"),
    )  # fmt: skip
    assert controller_of(text).loops["air"].protection.stale_after_s == 211.65
    assert "STALE_STEPS 255u" in files_of(text)["src/config.h"]


def test_two_converters_with_registers_share_no_name() -> None:
    wires = "chip_select: D{0}0, clock: D{0}1, data_in: D{0}2, data_out: D{0}3"
    air, wall = (f"{{kind: max31856, {wires.format(place)}}}" for place in (3, 4))
    settings = "period: 1 s, setpoint: {initial: 20 °C, minimum: 10 °C, maximum: 70 °C}"
    loop = f"{{sensor: wall, heater: other, {settings}, algorithm: {{kind: on_off}}}}"
    whole(changed(
        PLAIN, ("{kind: ds18b20, pin: A1, resolution: 12 bit}", f"{air}\n  wall: {wall}"),
        ("\nsafety:", f"  wall: {loop}\nsafety:"), ("board: uno", "board: mega2560"),
        ("outputs:", "outputs:\n  other: {kind: digital, pin: D22, power: 9 W}"),
    ))  # fmt: skip


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
    # The reset leads to heaters_off: D3 = PD3 low and driven before there is a stack.
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

CHECKED = ("chamber", "fabricator", "dryer", "kiln", "kiln_uno")


@pytest.mark.parametrize("case", [*CHECKED, *range(amount("drawn_for_cppcheck"))])
def test_nothing_is_found(case: str | int, tmp_path: Path) -> None:
    random = Random(f"cppcheck {SEED} {case}")  # noqa: S311 - no secret
    spec = example(case) if isinstance(case, str) else next(drawings(random)).spec
    board = spec.controller.board
    write(render(plan_firmware(spec)), tmp_path)
    assert shutil.which("cppcheck"), "sudo apt-get install cppcheck"
    done = subprocess.run(
        [*CPPCHECK, f"-D{board.macro}", f"-DF_CPU={board.clock_hz}UL", "src"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
