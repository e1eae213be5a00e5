"""The generated G-code files on this computer, with the checks of gcc's sanitizers."""

import struct
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from operator import xor
from pathlib import Path

HERE = Path(__file__).parent / "host_world"
FLAGS = [
    "-std=c11", "-g", "-O1", "-Wall", "-Wextra", "-Werror",
    "-fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero",
    "-fno-sanitize-recover=all", "-D__AVR_ATmega2560__", "-DF_CPU=16000000UL",
]  # fmt: skip
MINE = ("gcode", "host.", "text.")


def compile_world(files: Mapping[str, str], folder: Path) -> Path:
    """Compile the G-code files of a project with one tool, nozzle, and one fan, part_fan."""
    sources = []
    for path, text in files.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
        if target.suffix == ".c" and target.name.startswith(MINE):
            sources.append(target)
    program = folder / "world"
    includes = [f"-I{HERE}", f"-I{folder / 'src'}"]
    command = ["gcc", *FLAGS, *includes, *sources, HERE / "world.c", "-lm", "-o", program]
    subprocess.run(command, check=True)
    return program


def received(data: bytes) -> bytes:
    """Bytes that come in."""
    parts = [data[i : i + 0xFFFF] for i in range(0, len(data), 0xFFFF)]
    return b"".join(b"r" + struct.pack("<H", len(part)) + part for part in parts)


def ticks(count: int) -> bytes:
    return b"t" + struct.pack("<H", count)


def celsius(value: int) -> bytes:
    return b"c" + struct.pack("<h", value)


def tuning_ends(result: int) -> bytes:
    return b"a" + bytes([result])


def fault(code: int) -> bytes:
    return b"f" + bytes([code])


def numbered(number: int, line: str) -> bytes:
    """A line with its number and checksum."""
    text = f"N{number} {line}".encode()
    return text + b"*%d\n" % reduce(xor, text)


@dataclass(frozen=True)
class Said:
    """What was answered, and how things stood at the end."""

    lines: list[str]
    state: dict[str, str]

    @property
    def answers(self) -> list[str]:
        """Without the greeting."""
        assert self.lines[0] == "start"
        return self.lines[2:]


def run(program: Path, *script: bytes) -> Said:
    """Play a script."""
    done = subprocess.run([program], input=b"".join(script), capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    said, _, state = done.stdout.partition(b"=setpoint ")
    pairs = [line.split(" ", 1) for line in f"setpoint {state.decode()}".splitlines()]
    return Said(
        said.decode("ascii").splitlines(), {name.lstrip("="): value for name, value in pairs}
    )


def talk(program: Path, *lines: str | bytes, wait: int = 12) -> Said:
    """Send lines one by one, each with time for its answer."""
    script = [ticks(10)]
    for line in lines:
        data = line if isinstance(line, bytes) else f"{line}\n".encode()
        script += [received(data), ticks(wait)]
    return run(program, *script)
