"""The generated Modbus files on this computer, with the checks of gcc's sanitizers."""

import struct
import subprocess
from collections.abc import Iterable, Mapping
from pathlib import Path

HERE = Path(__file__).parent / "slave_world"
SANITIZE = (
    "-fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero",
    "-fno-sanitize-recover=all",
)
FLAGS = ("-std=c11", "-g", "-O1", "-ffp-contract=off", "-D__AVR_ATmega2560__", "-DF_CPU=16000000UL")
STRICT = ("-Wall", "-Wextra", "-Werror")


def write_sources(files: Mapping[str, str], folder: Path) -> list[Path]:
    """Write a project; return its Modbus files."""
    for path, text in files.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    return sorted((folder / "src").glob("modbus*.c"))


def compiled(sources: Iterable[Path], project: Path, program: Path, *flags: str) -> Path:
    """Compile Modbus files of a project for this computer."""
    includes = (f"-I{HERE}", f"-I{project / 'src'}")
    program.parent.mkdir(parents=True, exist_ok=True)
    command = ["gcc", *FLAGS, *flags, *includes, *sources, HERE / "world.c", "-o", program]
    subprocess.run(command, check=True, capture_output=True)
    return program


def frame(data: bytes) -> bytes:
    """A frame comes in, with silence behind it, and is answered."""
    return b"f" + struct.pack("<H", len(data)) + data


def received(data: bytes) -> bytes:
    """Bytes come in."""
    return b"r" + struct.pack("<H", len(data)) + data


def ticks(count: int) -> bytes:
    return b"t" + struct.pack("<H", count)


def value(what: str, number: float) -> bytes:
    return b"v" + what.encode() + struct.pack("<f", number)


def run(program: Path, script: Iterable[bytes]) -> list[bytes]:
    """Play a script; return what came out, piece by piece."""
    done = subprocess.run(
        [program], input=b"".join(script), capture_output=True, check=False, timeout=300
    )
    if done.returncode != 0:
        raise AssertionError(done.stderr.decode(errors="replace"))
    pieces, rest = [], memoryview(done.stdout)
    while rest:
        size = rest[0] | rest[1] << 8
        pieces.append(bytes(rest[2 : 2 + size]))
        rest = rest[2 + size :]
    return pieces
