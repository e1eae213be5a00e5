"""Compile a generated project for the host, file by file."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from heatwright.spec import Controller, DigitalOutput, Loop
from heatwright.spec.commands import commanded, tunable
from heatwright.spec.timers import allocate

HERE = Path(__file__).parent
INSTALL = "sudo apt install gcc libc6-dev"

TABLED = ("thermistor", "rtd", "analog")

PORTS = "ABCDEFGHJKL"
"""In the order of include/avr/io.h."""

FLAGS = ("-std=c11", "-ffp-contract=off", "-fPIC", "-fpack-struct=1", "-Wall", "-Wextra")
# Packed, as the AVR has it, structures give pointers to members at odd addresses.
# One changed file is compiled without warnings, and as fast as may be.
STRICT = ("-Werror", "-Wno-address-of-packed-member")
SANITIZE = (
    "-fsanitize=undefined,float-cast-overflow,float-divide-by-zero",
    "-fno-sanitize=alignment",
    "-fno-sanitize-recover=all",
)


class HostBuildFailed(RuntimeError):
    """The C does not compile, or there is no compiler; the message says which."""


class Parts(NamedTuple):
    """Names of the one loop and of what belongs to it."""

    loop: str
    sensor: str
    heater: str
    fan: str | None
    stepper: str | None
    has_output_state: bool
    table: bool
    """The sensor's readings are made temperatures by a table in a file of its own."""
    commanded: bool
    tunable: bool
    autotune: bool


@dataclass(frozen=True)
class HostBuild:
    """A compiled library and all that is needed to compile it again with one file changed."""

    library: Path
    project: Path
    controller: Controller
    parts: Parts
    sanitized: bool
    objects: Mapping[str, Path] = field(repr=False)
    """Object file by the name of its source."""

    def with_changed(self, name: str, text: str, folder: Path) -> HostBuild:
        """Compile one source anew, with another text, and link it with the others as they are.

        Raises:
            HostBuildFailed: it does not compile.

        """
        folder.mkdir(parents=True, exist_ok=True)
        changed = folder / name
        changed.write_text(text, encoding="utf-8")
        compiled = _compile(self, changed, folder, strict=False)
        objects = {**self.objects, name: compiled}
        library = _link(objects.values(), folder / "host.so", sanitized=self.sanitized)
        return HostBuild(
            library, self.project, self.controller, self.parts, self.sanitized, objects
        )


def build_host(
    project: Path, controller: Controller, folder: Path, *, sanitized: bool = True
) -> HostBuild:
    """Compile what decides in a generated project of one loop.

    Args:
        project: the generated project, with its `src/`.
        controller: the specification it was generated from.
        folder: where objects and library go.
        sanitized: end the process at undefined behaviour (gcc's sanitizer).

    Raises:
        HostBuildFailed: it does not compile, or there is no compiler.
        ValueError: the controller has more than one loop.

    """
    parts = _parts(controller)
    folder.mkdir(parents=True, exist_ok=True)
    build = HostBuild(folder / "host.so", project, controller, parts, sanitized, {})
    sources = [HERE / "world.c", *(project / "src" / name for name in _names(parts))]
    text = project / "src" / "text.c"
    if text.exists():  # only what shows numbers has it
        sources.append(text)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        compiled = list(pool.map(lambda source: _compile(build, source, folder), sources))
    objects = {source.name: made for source, made in zip(sources, compiled, strict=True)}
    _link(objects.values(), build.library, sanitized=sanitized)
    return HostBuild(build.library, project, controller, parts, sanitized, objects)


def _parts(controller: Controller) -> Parts:
    if len(controller.loops) != 1:
        message = "The host build has one loop"
        raise ValueError(message)
    ((name, loop),) = controller.loops.items()
    by_gain = tunable(controller, name)
    steppers = [each for each, output in controller.outputs.items() if output.kind == "stepper"]
    return Parts(
        loop=name,
        sensor=loop.sensor,
        heater=loop.heater,
        fan=loop.fan,
        stepper=next(iter(steppers), None),
        has_output_state=controller.outputs[loop.heater].kind != "digital",
        table=controller.sensors[loop.sensor].kind in TABLED,
        commanded=commanded(controller, name),
        tunable=by_gain,
        autotune=by_gain and loop.autotune is not None,
    )


def control_files(parts: Parts) -> list[str]:
    """Stems of what decides in a loop."""
    return ["loop", "guard", "algorithm", *(["autotune"] if parts.autotune else [])]


def _names(parts: Parts) -> list[str]:
    outputs = [f"output_{name}.c" for name in (parts.heater, parts.fan) if name]
    control = [f"{kind}_{parts.loop}.c" for kind in control_files(parts)]
    control += [f"celsius_{parts.sensor}.c"] * parts.table
    return [*control, "fault.c", "gate.c", "settings.c", *outputs]


def _compiler() -> str:
    found = shutil.which("gcc")
    if not found:
        message = f"There is no gcc: {INSTALL}"
        raise HostBuildFailed(message)
    return found


def _compile(build: HostBuild, source: Path, folder: Path, *, strict: bool = True) -> Path:
    made = folder / f"{source.stem}.o"
    _run(
        _compiler(),
        *FLAGS,
        *(STRICT if strict else ("-w", "-O0")),
        *(SANITIZE if build.sanitized else ("-O1",) * strict),
        *_board(build.controller),
        *(_names_for_world(build) if source.name == "world.c" else ()),
        *(f"-I{folder}" for folder in (build.project / "src", HERE / "include", HERE)),
        "-c",
        str(source),
        "-o",
        str(made),
    )
    return made


def _link(objects: Iterable[Path], library: Path, *, sanitized: bool) -> Path:
    # -Bsymbolic: nothing of another library, or of Python, in place of the firmware's own names.
    flags = ("-shared", "-Wl,-Bsymbolic", "-Wl,-z,defs", *(SANITIZE if sanitized else ()))
    _run(_compiler(), *flags, *map(str, objects), "-o", str(library))
    return library


def _run(*command: str) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode:
        raise HostBuildFailed(done.stderr.strip())


def _board(controller: Controller) -> list[str]:
    """Say what config.h asks for: the clock, and avr-gcc's macro of the chip."""
    board = controller.board
    chip = board.mcu.removeprefix("atmega").upper()
    return [f"-DF_CPU={board.clock_hz}UL", f"-D__AVR_ATmega{chip}__"]


def _names_for_world(build: HostBuild) -> list[str]:
    parts = build.parts
    control: Loop = build.controller.loops[parts.loop]
    flags = [f"-DLOOP={parts.loop}", f"-DSENSOR={parts.sensor}", f"-DHEATER={parts.heater}"]
    flags.append(f"-DPERIOD_TICKS={round(control.period_s * 100)}u")
    flags += [f"-DSTEPPER={parts.stepper}"] * (parts.stepper is not None)
    flags += ["-DCOMMANDED"] * parts.commanded + ["-DTUNABLE"] * parts.tunable
    flags += ["-DAUTOTUNE"] * parts.autotune
    headers = [f"{kind}_{parts.loop}.h" for kind in control_files(parts)]
    headers += [f"output_{parts.stepper}.h"] * (parts.stepper is not None)
    headers += [f"sensor_{parts.sensor}.h", f"output_{parts.heater}.h"]
    headers += ["fault.h", "gate.h", "reset.h", "settings.h", "config.h", "pins.h"]
    pins = build.controller.board.pins
    if parts.fan:
        fan = build.controller.outputs[parts.fan]
        assert isinstance(fan, DigitalOutput)  # noqa: S101 - the language allows no other fan
        pin = pins[fan.pin]
        mask = f"(1u<<{pin.bit})"
        off = "0u" if fan.active == "high" else mask
        flags += [f"-DFAN={parts.fan}", f"-DFAN_PORT={PORTS.index(pin.port)}"]
        flags += [f"-DFAN_MASK={mask}", f"-DFAN_OFF={off}"]
        headers.append(f"output_{parts.fan}.h")
    if parts.has_output_state:
        flags.append("-DHAS_STATE")
    flags += _pwm_flags(build.controller, parts.heater)
    return [*flags, *(part for header in headers for part in ("-include", header))]


def _pwm_flags(controller: Controller, heater: str) -> list[str]:
    """Say which registers tell for how long a pulse-width output is on."""
    pwm = allocate(controller).pwm.get(heater)
    if pwm is None:
        return []
    timer, channel = pwm.timer, pwm.channel
    flags = [
        f"-DPWM_COMPARE=OCR{timer}{channel}",
        f"-DPWM_WHOLE=OUTPUT_{heater.upper()}_PERIOD_COUNTS",
    ]
    if pwm.by_interrupts:
        return [
            *flags,
            f"-DPWM_COUNT=TCNT{timer}",
            f"-DPWM_ENABLED=(TIMSK{timer}&(1u<<OCIE{timer}{channel}))",
            f"-DPWM_INTERRUPT=TIMER{timer}_COMP{channel}_vect",
        ]
    return [*flags, f"-DPWM_CONTROL=TCCR{timer}A", f"-DPWM_BITS=(1u<<COM{timer}{channel}1)"]
