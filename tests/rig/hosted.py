"""Generated C on this computer, inside a world of the test's in C, as a program that plays scripts.

Each file is compiled once (`store`); a changed one is compiled alone and linked with the others.
"""

import subprocess
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from rig.store import made

HEADERS = Path(__file__).parent / "world"
"""avr-libc's headers, as far as the worlds need them."""
SANITIZED = (
    "-fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero",
    "-fno-sanitize-recover=all",
)
STRICT = ("-Wall", "-Wextra", "-Werror")
FLAGS = ("-std=c11", "-g", "-O1", "-ffp-contract=off", "-DF_CPU=16000000UL")
MOST_CPU_S = 20
"""Of the processor, for what takes one: a program that has lost its way takes all it can get."""


@dataclass(frozen=True)
class World:
    """How to compile some files of a firmware with a world around them."""

    sources: Mapping[str, str]
    """Files of the firmware's `src/`, by name; headers are there for the others."""
    files: tuple[str, ...]
    """The C files that are compiled."""
    world: Path
    """The C file of the test that is around them; what is beside it may be included."""
    flags: tuple[str, ...] = ()

    def program(self, changed: Mapping[str, str] | None = None) -> Path:
        """Compile and link; files that are changed are compiled without warnings."""
        headers = {name: text for name, text in self.sources.items() if name.endswith(".h")}
        headers |= {path.name: path.read_text("utf-8") for path in self.world.parent.glob("*.h")}
        texts = {name: self.sources[name] for name in self.files} | dict(changed or {})
        texts[self.world.name] = self.world.read_text("utf-8")
        beside = {
            f"avr_libc/{path.relative_to(HEADERS).as_posix()}": path.read_text("utf-8")
            for path in HEADERS.rglob("*.h")
        }
        objects = []
        for name, text in texts.items():
            strict = ("-w",) if changed and name in changed else STRICT
            words = ["gcc", *FLAGS, *strict, *self.flags, "-I.", "-Iavr_libc", "-c", name]
            objects.append(
                made([*words, "-o", "made.o"], headers | beside | {name: text}, "made.o")
            )
        link = ["gcc", *self.flags, *map(str, objects), "-lm", "-o", "program"]
        return made(link, {}, "program")

    def sanitized(self) -> "World":
        """Return the same with the checks of gcc's sanitizers."""
        return replace(self, flags=(*self.flags, *SANITIZED))


class Stopped(AssertionError):
    """The program ended in another way than it should: its last words."""


def play(program: Path, script: Iterable[bytes]) -> bytes:
    """Run a program with a script as its input; return what it says.

    Raises:
        Stopped: it crashed, or a sanitizer complained, or it did not end.

    """
    done = subprocess.run(
        ["prlimit", f"--cpu={MOST_CPU_S}", program], input=b"".join(script),
        capture_output=True, check=False,
    )  # fmt: skip
    if done.returncode:
        raise Stopped(done.stderr.decode(errors="replace") or f"status {done.returncode}")
    return done.stdout
