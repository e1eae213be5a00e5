"""Generated C on this computer, inside a world of the test's in C, which plays scripts. The world's
`main` reads a script from standard input and writes what happens to standard output. Each file is
compiled once (`made`); a changed one is compiled alone and linked with the others. As a program it
runs by itself, sanitized if so wished. As a library it plays in this process, a hundred times as
quick, but what crashes or hangs takes the process along: for arenas, whose `problem` asks the tests
of some modules."""

import ctypes
import inspect
import re
import struct
import subprocess
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from pathlib import Path
from types import ModuleType
from typing import Any

from rig.firmware import board_of, headers_of, made, sources_of

import heatwright.sim.host

HERE = Path(__file__).parent / "world"
"""What worlds share, and registers beyond those of the host build."""
HOST = Path(heatwright.sim.host.__file__).parent / "include"  # avr-libc's headers of the host build
SANITIZED = (
    "-fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero",
    "-fno-sanitize-recover=all",
)
STRICT = ("-Wall", "-Wextra", "-Werror")
FLAGS = ("-std=c11", "-g", "-O1", "-ffp-contract=off")
LIBRARY = ("-fPIC", "-DIN_PROCESS", "-D_DEFAULT_SOURCE")
BOUND = ("-shared", "-Wl,-Bsymbolic", "-Wl,-z,defs")
"""Nothing of another library, or of Python, stands in for the firmware's own names."""
MOST_CPU_S = 20
"""Limit of the processor's time: a program that has lost its way takes all it can get."""


@dataclass(frozen=True)
class World:
    """How to compile some files of a firmware with a world around them."""

    sources: Mapping[str, str]
    """Files of the firmware's `src/`, by name; headers are there for the others."""
    files: tuple[str, ...]  # the C files that are compiled
    world: Path  # the C file of the test that is around them; what is beside it may be included
    flags: tuple[str, ...] = ()

    def program(self, changed: Mapping[str, str] | None = None) -> Path:
        """Compile and link a program; files that are changed are compiled without warnings."""
        objects = self._objects(changed or {}, ())
        return made(["gcc", *self.flags, *objects, "-lm", "-o", "program"], {}, "program")

    def library(self, changed: Mapping[str, str] | None = None) -> Path:
        """Compile and link a library, for `play` in this process."""
        objects = self._objects(changed or {}, LIBRARY)
        return made(["gcc", *self.flags, *BOUND, *objects, "-lm", "-o", "world.so"], {}, "world.so")

    def sanitized(self) -> "World":
        """Return the same with the checks of gcc's sanitizers; for programs."""
        return replace(self, flags=(*self.flags, *SANITIZED))

    def _objects(self, changed: Mapping[str, str], flags: tuple[str, ...]) -> list[str]:
        texts = {self.world.name: self.world.read_text("utf-8")}  # linked first: see script.h
        texts |= {name: self.sources[name] for name in self.files}
        texts |= {name: text for name, text in changed.items() if name.endswith(".c")}
        include = made(["true"], self._headers(changed), "avr_libc/host/avr/io.h").parents[3]
        places = [f"-I{include / place}" for place in ("", "avr_libc/more", "avr_libc/host")]
        objects = []
        for name, text in texts.items():
            strict = ("-w",) if name in changed else STRICT
            words = ["gcc", *FLAGS, *strict, *self.flags, *flags, *places, "-c", name]
            objects.append(str(made([*words, "-o", "made.o"], {name: text}, "made.o")))
        return objects

    def _headers(self, changed: Mapping[str, str]) -> dict[str, str]:
        headers = headers_of(self.sources) | headers_of(changed)
        headers |= {path.name: path.read_text("utf-8") for path in self.world.parent.glob("*.h")}
        for name, folder in {"more": HERE, "host": HOST}.items():
            for path in folder.rglob("*.h"):
                place = path.relative_to(folder).as_posix()
                headers[f"avr_libc/{name}/{place}"] = path.read_text("utf-8")
        return headers


def world_of(spec: str, files: Iterable[str], world: Path, *flags: str) -> World:
    """Return the world around files of a spec's firmware (its text, or an example's name)."""
    board = board_of(spec)
    chip = f"-D__AVR_ATmega{board.mcu.removeprefix('atmega').upper()}__"
    clock = f"-DF_CPU={board.clock_hz}UL"
    return World(sources_of(spec), tuple(sorted(files)), world, (chip, clock, *flags))


# A line's share of a script, which all worlds of one take in this form.


def received(data: bytes) -> bytes:
    parts = [data[i : i + 0xFFFF] for i in range(0, len(data), 0xFFFF)]
    return b"".join(b"r" + struct.pack("<H", len(part)) + part for part in parts)


def flagged(flags: int, byte: int) -> bytes:
    """A byte that comes in with the receiver's flags."""
    return b"x" + bytes([flags, byte])


def ticks(count: int) -> bytes:
    return b"t" + struct.pack("<H", count)


class Stopped(AssertionError):
    """The program ended in another way than it should: its last words."""


def play(world: Path, script: Iterable[bytes]) -> bytes:
    """Let a program, or a library, play a script; return what it says.

    Raises Stopped: it crashed, or a sanitizer complained, or it did not end.
    """
    if world.suffix == ".so":
        return _played(_loaded(world), b"".join(script))
    done = subprocess.run(
        ["prlimit", f"--cpu={MOST_CPU_S}", world], input=b"".join(script),
        capture_output=True, check=False,
    )  # fmt: skip
    if done.returncode:
        raise Stopped(done.stderr.decode(errors="replace") or f"status {done.returncode}")
    return done.stdout


@cache
def _loaded(library: Path | None) -> ctypes.CDLL:
    """Load a library; with None, what this process has already: its C library."""
    return ctypes.CDLL(str(library) if library else None)


def _played(library: ctypes.CDLL, script: bytes) -> bytes:
    said, size = ctypes.c_void_p(), ctypes.c_size_t()
    status = library.world_play(
        script, ctypes.c_size_t(len(script)), ctypes.byref(said), ctypes.byref(size)
    )
    words = ctypes.string_at(said, size.value)
    _loaded(None).free(said)
    if status:
        raise Stopped(words.rpartition(b"\n")[2].decode(errors="replace"))
    return words


TRAPS = (
    "-fsanitize=undefined,float-cast-overflow,float-divide-by-zero",
    "-fsanitize-undefined-trap-on-error",
)
"""What C leaves undefined, such as an index behind an array, ends the judge's process."""


def first_complaint(modules: Iterable[ModuleType], **given: Any) -> str:
    """Run the tests that need nothing but what is given in place of fixtures, in their order, with
    all of their parameters, until one fails. A function is called anew for each test."""
    for module in modules:
        for test, cases in tests_of(module, set(given)):
            for case in cases:
                wanted = inspect.signature(test).parameters.keys() & given.keys()
                try:
                    test(**{name: _made(given[name]) for name in wanted}, **case)
                except Exception as error:
                    return f"{test.__name__} {case or ''}: {error!r}"[:500]
    return ""


def tests_of(
    module: ModuleType, given: set[str]
) -> Iterator[tuple[Callable[..., None], list[dict[str, Any]]]]:
    for name, test in vars(module).items():
        if name.startswith("test_") and callable(test):
            cases = list(_cases(test))
            if inspect.signature(test).parameters.keys() <= given | cases[0].keys():
                yield test, cases


def _cases(test: Callable[..., None]) -> Iterator[dict[str, Any]]:
    marks = [mark for mark in getattr(test, "pytestmark", []) if mark.name == "parametrize"]
    for values in product(*(mark.args[1] for mark in marks)):
        case: dict[str, Any] = {}
        for mark, value in zip(marks, values, strict=True):
            names = mark.args[0]
            case |= (
                {names: value} if isinstance(names, str) else dict(zip(names, value, strict=True))
            )
        yield case


def _made(given: Any) -> Any:
    return given() if inspect.isfunction(given) or inspect.ismethod(given) else given


class InItsWorld:
    """An arena: files of a firmware broken, in a world of the test's on this computer."""

    together = True

    def __init__(
        self, name: str, world: Callable[[], World], judge: Callable[[Path], str], broken: str = ""
    ) -> None:
        """Say what is broken: the files of that world whose names match; the judge says the first
        thing wrong."""
        self.name, self._world, self.problem = name, cache(world), judge
        self._broken = re.compile(broken)

    def sources(self) -> Mapping[str, str]:
        world = self._world()
        return {name: world.sources[name] for name in world.files if self._broken.match(name)}

    def headers(self) -> Mapping[str, str]:
        return headers_of(self._world().sources)

    def build(self, changed: Mapping[str, str], folder: Path) -> Path:  # noqa: ARG002
        world = self._world()
        return replace(world, flags=(*world.flags, *TRAPS)).library(changed)

    def prepare(self) -> None:
        """Let the judge compute and keep what all trials share."""
        self.problem(self.build({}, Path()))
