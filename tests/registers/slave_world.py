"""The generated Modbus files on this computer, with the checks of gcc's sanitizers."""

import struct
import subprocess
from collections.abc import Iterable, Mapping
from pathlib import Path

HERE = Path(__file__).parent / "slave_world"
WORLD = HERE / "world.c"
SANITIZE = (
    "-fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero",
    "-fno-sanitize-recover=all",
)
MOST_CPU_S = 5
"""Of the processor, for what takes less than one; a slave that has lost its way takes all."""
FLAGS = ("-std=c11", "-g", "-O0", "-ffp-contract=off", "-D__AVR_ATmega2560__", "-DF_CPU=16000000UL")
STRICT = ("-Wall", "-Wextra", "-Werror")


def write_sources(files: Mapping[str, str], folder: Path) -> list[Path]:
    """Write a project; return its Modbus files."""
    for path, text in files.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    return sorted((folder / "src").glob("modbus*.c"))


def compiled(sources: Iterable[Path], project: Path, folder: Path, *flags: str) -> list[Path]:
    """Compile files of a project, or of the world, for this computer."""
    folder.mkdir(parents=True, exist_ok=True)
    made = []
    for source in sources:
        made.append(folder / f"{source.stem}.o")
        includes = (f"-I{HERE}", f"-I{project / 'src'}")
        command = ["gcc", *FLAGS, *flags, *includes, "-c", source, "-o", made[-1]]
        subprocess.run(command, check=True, capture_output=True)
    return made


def linked(objects: Iterable[Path], program: Path, *flags: str) -> Path:
    """Link the slave and its world."""
    subprocess.run(["gcc", *flags, *objects, "-o", program], check=True, capture_output=True)
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
        ["prlimit", f"--cpu={MOST_CPU_S}", program], input=b"".join(script),
        capture_output=True, check=False,
    )  # fmt: skip
    if done.returncode != 0:
        raise AssertionError(done.stderr.decode(errors="replace"))
    pieces, rest = [], memoryview(done.stdout)
    while rest:
        size = rest[0] | rest[1] << 8
        pieces.append(bytes(rest[2 : 2 + size]))
        rest = rest[2 + size :]
    return pieces
