"""Whether a mutant is the same program: avr-gcc makes the same machine code of it."""

import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path

CHIPS = ("atmega2560", "atmega328p", "atmega32")
"""The first one of which the original compiles: of some the registers have other names."""
FLAGS = ("-O2", "-std=c11", "-fpack-struct=1", "-DF_CPU=16000000UL", "-w", "-g0")


def same_machine_code(file: str, texts: Mapping[str, str], changed: str) -> bool:
    """Compile a file as it is and with another text, among the headers of its firmware."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for name, text in texts.items():
            if name.endswith(".h"):
                (folder / name).write_text(text, encoding="utf-8")
        for chip in CHIPS:
            original = _compiled(folder, file, texts[file], chip)
            if original is not None:
                return original == _compiled(folder, file, changed, chip)
    return False


def _compiled(folder: Path, file: str, text: str, chip: str) -> bytes | None:
    (folder / file).write_text(text, encoding="utf-8")
    command = ["avr-gcc", f"-mmcu={chip}", *FLAGS, "-c", file, "-o", "made.o"]
    done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    return (folder / "made.o").read_bytes() if done.returncode == 0 else None
