"""From a specification to a program in the simulated processor: the tests' specs, what is generated
from them, and C compiled for it; each is read, generated and compiled once. The C is a small
program, parts of a firmware with a `main` of the test's, or a whole firmware. What was compiled is
in `build/rig`, by the content of all that goes into it."""

import hashlib
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from runpy import run_path
from types import MappingProxyType
from typing import Any

import numpy as np
import yaml

from heatwright.generator import plan_firmware, render
from heatwright.sim.avr import Avr
from heatwright.sim.binary.dwarf import Variables
from heatwright.sim.binary.elf import Elf
from heatwright.sim.device import AvrDevice
from heatwright.spec import Board as BoardData
from heatwright.spec import Controller, Spec, load, load_text
from heatwright.templates import __file__ as templates

STORE = Path(__file__).parents[2] / "build" / "rig"


def finished(
    command: Sequence[Any], *, check: bool = False, **given: Any
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(list(command), capture_output=True, text=True, check=check, **given)


class CompileFailed(AssertionError):
    """The compiler's words."""


@cache
def _version(compiler: str) -> str:
    return finished([compiler, "--version"], check=True).stdout


def kept(name: str, product: str, make: Callable[[Path], None]) -> Path:
    """Return the folder of this name in the store; without its product, it is made anew."""
    place = STORE / name
    if not (place / product).exists():
        STORE.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix="making-", dir=STORE))
        make(folder)
        try:
            folder.rename(place)
        except OSError:  # another process was quicker
            shutil.rmtree(folder)
    return place


def made(command: Sequence[str], texts: Mapping[str, str], product: str) -> Path:
    """Run a compiler in a folder with these files, and return its product, or raise CompileFailed.
    The same command with the same files is run once; the folder stays in the store."""

    def run(folder: Path) -> None:
        for path, text in texts.items():
            target = folder / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, encoding="utf-8")
        done = finished(command, cwd=folder)
        if done.returncode:
            shutil.rmtree(folder)
            raise CompileFailed(done.stderr)

    key = repr((_version(command[0]), list(command), sorted(texts.items()), product))
    return kept(hashlib.sha256(key.encode()).hexdigest()[:24], product, run) / product


ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "spec" / "examples"
EXAMPLE_NAMES = sorted(path.stem for path in EXAMPLES.glob("*.yaml"))


@cache
def example(name: str) -> Spec:
    return load(EXAMPLES / f"{name}.yaml")


@cache
def spec_of(text: str) -> Spec:
    return load_text(text, "spec.yaml")


def controller_of(spec: str) -> Controller:
    return (spec_of(spec) if "\n" in spec else example(spec)).controller


@cache
def files_of(spec: str) -> Mapping[str, str]:
    """Generate the project of a spec's text, or of the example of that name: path and text."""
    found = spec_of(spec) if "\n" in spec else example(spec)
    return MappingProxyType(dict(render(plan_firmware(found))))


def sources_of(spec: str) -> dict[str, str]:
    files = files_of(spec)
    return {path.removeprefix("src/"): files[path] for path in files if path.startswith("src/")}


def headers_of(texts: Mapping[str, str]) -> dict[str, str]:
    return {name: text for name, text in texts.items() if name.endswith(".h")}


def changed(spec: str, *changes: tuple[str, str]) -> str:
    """Return a spec's text, or that of the example of that name, with parts of it replaced."""
    text = spec if "\n" in spec else (EXAMPLES / f"{spec}.yaml").read_text("utf-8")
    for old, new in changes:
        assert text.count(old) == 1, f"it stands there {text.count(old)} times: {old}"
        text = text.replace(old, new)
    return text


def plain(data: Any) -> Any:
    """Return a loaded spec as mappings and lists that can be changed."""
    if isinstance(data, Mapping):
        return {key: plain(value) for key, value in data.items()}
    return [plain(each) for each in data] if isinstance(data, tuple | list) else data


def put(data: Any, path: str, value: Any) -> None:
    """Put a value at a place like `loops.air.period`; None takes away what is there."""
    *way, last = (int(part) if part.isdecimal() else part for part in path.split("."))
    for part in way:
        data = data[part] if isinstance(data, list) else data.setdefault(part, {})
    if value is None:
        data.pop(last)
    elif isinstance(data, list):
        data[last : last + 1] = [value]  # also behind the last one
    else:
        data[last] = value


def edited(spec: str, changes: str) -> str:
    """Return a spec's text, or that of the example of that name, with other values at places.

    changes -- in YAML, a line for each, such as `loops.air.period: 2 s`; `null` takes one away.
    """
    found = spec_of(spec) if "\n" in spec else example(spec)
    data = plain(found.tree.data)
    for path, value in yaml.safe_load(changes).items():
        put(data, path, value)
    return yaml.dump(data, allow_unicode=True, sort_keys=False)


def flow(value: Any) -> str:
    """Write what yaml.BaseLoader has read, all of it texts, without quotes."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key}: {flow(each)}' for key, each in value.items())}}}"
    return f"[{', '.join(map(flow, value))}]" if isinstance(value, list) else str(value)


TEMPLATES = Path(templates).parent
CLOCK_HZ = 16_000_000
SHARED = Path(__file__).parents[1] / "sim_native" / "firmware"
PRELUDE = """
#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <stdbool.h>
#include <stdint.h>
#include <util/delay.h>
"""
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror")
FLAGS = ("-Os", "-gdwarf-2", "-std=c11", "-fpack-struct=1", "-ffunction-sections",
         "-fdata-sections")  # fmt: skip
LITTLE_FLASH = 16384  # bytes; there it is linked with short jumps, as the project does everywhere
Changed = Mapping[str, str]
"""Files of a firmware, by name, that have another text: a mutant is compiled without warnings."""


def compiled(source: str, *flags: str, mcu: str = "atmega328p") -> Elf:
    """Compile a small program, or what its `main` does before it stays; with the usual headers."""
    if "main(" not in source:
        source = f"int main(void) {{ {source} for (;;) {{}} }}"
    command = ["avr-gcc", f"-mmcu={mcu}", f"-DF_CPU={CLOCK_HZ}UL", "-Os"]
    command += [] if any(flag.startswith("-g") for flag in flags) else ["-gdwarf-2"]
    command += ["-std=gnu11", "-Wall", "-Wno-unused-function", *flags, "test.c", "-o", "test.elf"]
    text = f'{PRELUDE}\n#line 1 "test.c"\n{source}'
    return Elf(made(command, {"test.c": text}, "test.elf"))


def shared(name: str, *flags: str, mcu: str = "atmega328p") -> Elf:
    """Compile one of the files in tests/sim_native/firmware."""
    return compiled((SHARED / name).read_text("utf-8"), *flags, mcu=mcu)


def powered(program: Elf, mcu: str = "atmega328p") -> Avr:
    avr = Avr(mcu, CLOCK_HZ)
    avr.load(program)
    return avr


def running(source: str, *flags: str, mcu: str = "atmega328p") -> Avr:
    return powered(compiled(source, *flags, mcu=mcu), mcu)


def part(
    spec: str, names: Iterable[str], main: str, *flags: str, changed: Changed | None = None
) -> Elf:
    """Compile some files of a spec's firmware (see `Program`) with a main program."""
    return Program(spec, tuple(names), main, flags).elf(changed)


def whole(spec: str, *flags: str, changed: Changed | None = None) -> Elf:
    """Compile the whole firmware of a spec (its text, or the name of an example)."""
    return Program(spec, flags=flags).elf(changed)


def device_of(spec: str, felt_c: float | None = None, elf: Elf | None = None) -> AvrDevice:
    """Power on the board of a spec, its thermometers at a temperature; with another binary if
    there is one."""
    controller = controller_of(spec)
    device = AvrDevice(controller, elf or whole(spec))
    for sensor in controller.thermometers if felt_c is not None else ():
        device.sense(sensor, felt_c)
    return device


@cache
def began_s(spec: str) -> float:
    """Return when the first tick of a spec's firmware begins, s after the power came on. A
    controller that checks itself starts late: its watchdog resets it once, and it goes through all
    of its memory."""
    controller = controller_of(spec)
    device = AvrDevice(controller, whole(spec))
    name, loop = next(iter(controller.loops.items()))
    while not len(device.steps(name)):
        device.advance(device.time_s + loop.period_s)
    return float(device.steps(name)["time_s"][0]) - loop.period_s


@dataclass(frozen=True)
class Program:
    """Some files of a spec's firmware with a main program; without one, the whole firmware."""

    spec: str  # its text, or the name of an example
    names: tuple[str, ...] = ()  # the files, without their ending
    main: str = ""  # the text of main.c, if there is to be another one
    flags: tuple[str, ...] = ()

    def texts(self) -> dict[str, str]:
        """Return what is compiled, and all headers: name in `src/`, and text."""
        texts = sources_of(self.spec)
        if not self.main:
            return texts
        chosen = {f"{name}.c" for name in self.names}
        return headers_of(texts) | {name: texts[name] for name in chosen} | {"main.c": self.main}

    def elf(self, changed: Changed | None = None, folder: Path | None = None) -> Elf:
        """Compile it: strictly, or with files that are changed, without warnings. In a folder are
        left what depends on those files, and the binary; all else, and all without a folder, is
        kept in the store."""
        texts = self.texts() | dict(changed or {})
        headers = headers_of(texts)
        stale = set(texts) if set(changed or ()) & set(headers) else set(changed or ())
        words = self._words(strict=not changed)
        objects = []
        for name in sorted(each for each in texts if each.endswith(".c")):
            command = [*words, "-c", name, "-o", f"{name}.o"]
            place = folder if name in stale else None
            objects.append(_made(command, headers | {name: texts[name]}, f"{name}.o", place))
        link = [*words, "-Wl,--gc-sections", *map(str, objects), "-lm", "-o", "firmware.elf"]
        built = _made(link, {}, "firmware.elf", folder)
        if not self.main and "seal.py" in files_of(self.spec):
            _sealer()["seal"](built)
        return Elf(built)

    def _words(self, *, strict: bool) -> list[str]:
        board = board_of(self.spec)
        chip = [f"-mmcu={board.mcu}", f"-DF_CPU={board.clock_hz}UL"]
        relaxed = ["-Wl,--relax"] if board.flash_bytes <= LITTLE_FLASH else []
        return ["avr-gcc", *chip, *FLAGS, *relaxed, *(WARNINGS if strict else ("-w",)), *self.flags]


@cache
def _sealer() -> dict[str, Any]:
    """Return what the script defines that PlatformIO runs behind the linker."""
    return run_path(str(TEMPLATES / "project" / "seal.py"))


def _made(command: list[str], texts: Mapping[str, str], product: str, folder: Path | None) -> Path:
    """Run a compiler in a folder, or in the store."""
    if folder is None:
        return made(command, texts, product)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    done = finished(command, cwd=folder)
    if done.returncode:
        raise CompileFailed(done.stderr)
    return folder / product


@dataclass(frozen=True)
class Firmware:
    """An arena of the mutation engine (tests/mutation/arena.py): a program on a simulated AVR."""

    name: str
    program: Program
    broken: tuple[str, ...]  # the files that are broken, without their ending
    checks: tuple[Callable[[Elf], object], ...]
    """Each is given the binary; it says what is wrong with it, or raises. Quick ones first."""
    together: bool = False

    def headers(self) -> dict[str, str]:
        return headers_of(self.program.texts())

    def sources(self) -> dict[str, str]:
        texts = self.program.texts()
        return {f"{name}.c": texts[f"{name}.c"] for name in self.broken}

    def build(self, changed: Changed, folder: Path) -> Path:
        return self.program.elf(changed, folder).path

    def prepare(self) -> None:
        self.program.elf(changed={name: f"{text}\n" for name, text in self.sources().items()})

    def problem(self, built: Path) -> str:
        for check in self.checks:
            if found := check(Elf(built)):
                return str(found)
        return ""


def on(
    bench: Callable[[Elf], Any], *checks: Callable[[Any], object]
) -> tuple[Callable[[Elf], object], ...]:
    """Make checks of a bench into checks of a binary: each on a bench of its own."""
    return tuple(lambda elf, check=check: check(bench(elf)) for check in checks)


def board_of(spec: str) -> BoardData:
    return controller_of(spec).board


class Board:
    """A processor with a program whose variables can be read and set."""

    def __init__(self, elf: Elf, board: BoardData) -> None:
        self.board = board
        self.program = elf
        self.avr = Avr(board.mcu, board.clock_hz)
        self.avr.load(elf)
        self._variables = Variables(elf)

    def __contains__(self, name: str) -> bool:
        return name in self._variables

    def put(self, name: str, value: float) -> None:
        variable = self._variables[name]
        self.avr.write_ram(variable.address, np.asarray(value, variable.dtype).tobytes())

    def get(self, name: str) -> Any:
        variable = self._variables[name]
        raw = self.avr.read_ram(variable.address, variable.size)
        return np.frombuffer(raw, variable.dtype)[0]


class Small:
    """Compiled, powered on, and run for so long; a variable is had by its name, as Python's."""

    def __init__(
        self, source: str, *flags: str, mcu: str = "atmega328p", seconds: float = 0.0
    ) -> None:
        self.elf = compiled(source, *flags, mcu=mcu)
        self.avr = powered(self.elf, mcu)
        self.avr.run(seconds)

    @cached_property
    def _variables(self) -> Variables:
        return Variables(self.elf)

    def __getitem__(self, name: str) -> Any:
        variable = self._variables[name]
        raw = self.avr.read_ram(variable.address, variable.size)
        found = np.frombuffer(raw, variable.dtype.base)
        return found.tolist() if variable.dtype.shape else found[0].item()

    def __setitem__(self, name: str, value: float | Sequence[float]) -> None:
        variable = self._variables[name]
        self.avr.write_ram(variable.address, np.asarray(value, variable.dtype.base).tobytes())
