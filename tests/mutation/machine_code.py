"""Whether a mutant is the same program: avr-gcc makes the same machine code of it."""

import subprocess
import tempfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

CHIPS = ("atmega2560", "atmega328p", "atmega32")
"""The first one of which the original compiles: of some the registers have other names."""
FLAGS = ("-O2", "-std=c11", "-fpack-struct=1", "-DF_CPU=16000000UL", "-w", "-g0")


def same_machine_code(file: str, texts: Mapping[str, str], changed: str) -> bool:
    """Compile a file as it is and with another text, among the headers of its firmware."""
    headers = tuple(sorted(item for item in texts.items() if item[0].endswith(".h")))
    for chip in CHIPS:
        original = _original(headers, file, texts[file], chip)
        if original is not None:
            return original == _compiled(headers, file, changed, chip)
    return False


def _compiled(
    headers: tuple[tuple[str, str], ...], file: str, text: str, chip: str
) -> bytes | None:
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for name, content in (*headers, (file, text)):
            (folder / name).write_text(content, encoding="utf-8")
        command = ["avr-gcc", f"-mmcu={chip}", *FLAGS, "-c", file, "-o", "made.o"]
        done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
        return (folder / "made.o").read_bytes() if done.returncode == 0 else None


_original = cache(_compiled)
