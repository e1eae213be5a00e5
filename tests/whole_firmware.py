"""A spec's whole firmware, compiled as strictly as a project is, with a line broken where asked."""

import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import NamedTuple

from heatwright.generator import plan_firmware, render
from heatwright.sim.elf import Elf
from heatwright.spec import Spec, load_text

WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror"]
FLAGS = ["-Os", "-gdwarf-2", "-std=c11", "-fpack-struct=1", "-ffunction-sections"]


class Broken(NamedTuple):
    """A line of a source of the firmware, and what stands in its place."""

    file: str
    right: str
    wrong: str


@cache
def spec_of(text: str) -> Spec:
    """Read a spec."""
    return load_text(text, "spec.yaml")


def whole(text: str, broken: Broken | None = None) -> Elf:
    """Compile the firmware of a spec's text; all but the broken file only once."""
    folder = _objects(text)
    objects = {each.stem: each for each in sorted(folder.glob("*.o"))}
    place = Path(tempfile.mkdtemp(prefix="linked-", dir=folder))
    if broken:
        sound = (folder / broken.file).read_text("utf-8")
        assert broken.right in sound, broken
        changed = place / broken.file
        changed.write_text(sound.replace(broken.right, broken.wrong, 1), encoding="utf-8")
        _avr_gcc(text, "-w", f"-I{folder}", "-c", changed, "-o", changed.with_suffix(".o"))
        objects[changed.stem] = changed.with_suffix(".o")
    elf = place / "firmware.elf"
    _avr_gcc(text, "-Wl,--gc-sections", *objects.values(), "-lm", "-o", elf)
    return Elf(elf)


@cache
def _objects(text: str) -> Path:
    folder = Path(tempfile.mkdtemp(prefix="whole-firmware-"))
    for path, source in render(plan_firmware(spec_of(text))).items():
        if path.startswith("src/"):
            (folder / Path(path).name).write_text(source, encoding="utf-8")
    for source in folder.glob("*.c"):
        _avr_gcc(text, *WARNINGS, "-c", source, "-o", source.with_suffix(".o"))
    return folder


def _avr_gcc(text: str, *arguments: str | Path) -> None:
    board = spec_of(text).controller.board
    chip = [f"-mmcu={board.mcu}", f"-DF_CPU={board.clock_hz}UL"]
    subprocess.run(["avr-gcc", *chip, *FLAGS, *map(str, arguments)], check=True)
