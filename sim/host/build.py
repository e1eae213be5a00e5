"""Compile a generated project for the host, file by file."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from heatwright.sim.host.parts import (
    Parts,
    control_files,
    names_for_loop,
    names_for_world,
    parts_of,
    program_files,
)
from heatwright.spec import Controller

HERE = Path(__file__).parent
INSTALL = "sudo apt-get install gcc libc6-dev"

FLAGS = ("-std=c11", "-ffp-contract=off", "-fPIC", "-fpack-struct=1", "-Wall", "-Wextra")
# Structures are packed as on the AVR, so pointers to their members may be unaligned.
# A single changed file is compiled without warnings, as fast as possible.
STRICT = ("-Werror", "-Wno-address-of-packed-member")
SANITIZE = (
    "-fsanitize=undefined,float-cast-overflow,float-divide-by-zero",
    "-fno-sanitize=alignment",
    "-fno-sanitize-recover=all",
)


class HostBuildFailed(RuntimeError):
    """The C does not compile, or there is no compiler; the message says which."""


@dataclass(frozen=True)
class HostBuild:
    """A compiled library, and what is needed to compile it again with one file changed."""

    library: Path
    project: Path
    controller: Controller
    loops: tuple[Parts, ...]
    sanitized: bool
    objects: Mapping[str, Path] = field(repr=False)
    """Object files by the name of their source."""

    @property
    def parts(self) -> Parts:
        """The parts of the first loop."""
        return self.loops[0]

    def with_changed(self, name: str, text: str, folder: Path) -> HostBuild:
        """Compile one source with another text, and link it with the existing other objects.

        Raises HostBuildFailed: it does not compile.
        """
        folder.mkdir(parents=True, exist_ok=True)
        changed = folder / name
        changed.write_text(text, encoding="utf-8")
        compiled = _compile(self, changed, changed.with_suffix(".o"), strict=False)
        objects = {**self.objects, name: compiled}
        library = _link(objects.values(), folder / "host.so", sanitized=self.sanitized)
        return HostBuild(
            library, self.project, self.controller, self.loops, self.sanitized, objects
        )


def build_host(
    project: Path, controller: Controller, folder: Path, *, sanitized: bool = True
) -> HostBuild:
    """Compile the files of a generated project that decide about heaters.

    project -- the generated project, with its `src/`; controller -- the specification it was
    generated from; folder -- the output folder of objects and library; sanitized -- end the process
    at undefined behaviour (gcc's sanitizer). Raises HostBuildFailed: it does not compile, or there
    is no compiler.
    """
    loops = parts_of(controller)
    folder.mkdir(parents=True, exist_ok=True)
    build = HostBuild(folder / "host.so", project, controller, loops, sanitized, {})
    names = dict.fromkeys(name for parts in loops for name in _names(parts))
    if (project / "src" / "text.c").exists():  # only projects that show numbers have it
        names["text.c"] = None
    jobs = [(HERE / "world.c", folder / "world.o", names_for_world(controller, loops))]
    jobs += [
        (HERE / "loop.c", folder / f"world_{each.name}.o", names_for_loop(controller, each))
        for each in loops
    ]
    jobs += [(project / "src" / name, (folder / name).with_suffix(".o"), []) for name in names]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        compiled = list(pool.map(lambda job: _compile(build, *job), jobs))
    objects = {f"{made.stem}.c": made for made in compiled}
    _link(objects.values(), build.library, sanitized=sanitized)
    return HostBuild(build.library, project, controller, loops, sanitized, objects)


def _names(parts: Parts) -> list[str]:
    outputs = [f"output_{name}.c" for name in (parts.heater, parts.fan, parts.cooler) if name]
    control = [f"{kind}_{parts.name}.c" for kind in control_files(parts)]
    control += [f"celsius_{parts.sensor}.c"] * parts.table
    if parts.ammeter:
        control += [f"current_{parts.heater}.c", f"amperes_{parts.ammeter}.c"]
    control += [f"{name}.c" for name in program_files(parts)]
    control += [f"response_{parts.name}.c"] * parts.response
    control += [f"proof_{fan}.c" for fan in parts.all_proven]
    control += ["inputs.c"] * parts.inputs
    control += ["relay.c"] * (parts.relay is not None)
    control += ["countdown.c"] * bool(parts.countdown)
    for name, sensor, _, has_table in parts.watched:
        control += [f"monitor_{name}.c", *([f"celsius_{sensor}.c"] * has_table)]
    return [*control, "fault.c", "gate.c", "settings.c", *outputs]


def _compiler() -> str:
    found = shutil.which("gcc")
    if not found:
        raise HostBuildFailed(f"There is no gcc: {INSTALL}")
    return found


def _compile(
    build: HostBuild, source: Path, made: Path, names: Iterable[str] = (), *, strict: bool = True
) -> Path:
    _run(
        _compiler(),
        *FLAGS,
        *(STRICT if strict else ("-w", "-O0")),
        *(SANITIZE if build.sanitized else ("-O1",) * strict),
        *_board(build.controller),
        *names,
        *(f"-I{folder}" for folder in (build.project / "src", HERE / "include", HERE)),
        "-c",
        str(source),
        "-o",
        str(made),
    )
    return made


def _link(objects: Iterable[Path], library: Path, *, sanitized: bool) -> Path:
    # -Bsymbolic: the firmware's names mean its own functions, never another library's or Python's.
    flags = ("-shared", "-Wl,-Bsymbolic", "-Wl,-z,defs", *(SANITIZE if sanitized else ()))
    in_order = sorted(objects, key=lambda made: made.name != "world.o")  # see world.c
    _run(_compiler(), *flags, *map(str, in_order), "-o", str(library))
    return library


def _run(*command: str) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode:
        raise HostBuildFailed(done.stderr.strip())


def _board(controller: Controller) -> list[str]:
    """Return the macros that config.h needs: the clock, and avr-gcc's macro of the chip."""
    board = controller.board
    return [f"-DF_CPU={board.clock_hz}UL", f"-D{board.macro}"]
