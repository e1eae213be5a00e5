"""Combine the parts: files, constants, pins, and the order of start and tick."""

from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from itertools import chain
from typing import TypeVar

from heatwright.generator.plan import core
from heatwright.generator.plan.checks import plan_checks
from heatwright.generator.plan.documents.readme import project_files
from heatwright.generator.plan.loop.loops import plan_loop
from heatwright.generator.plan.loop.names import summary
from heatwright.generator.plan.numbers import TICK_MS
from heatwright.generator.plan.outputs.common import UseOfOutput, cools, watched
from heatwright.generator.plan.parts import MARK, Call, File, Group, Header, Part, PinPlan, Plan
from heatwright.generator.plan.programs import program
from heatwright.generator.plan.programs.programs import programs as plan_programs
from heatwright.generator.plan.protection import relay
from heatwright.generator.plan.protection.inputs import plan_inputs
from heatwright.generator.plan.protection.proof import plan_proofs
from heatwright.generator.plan.sensors.common import use_of
from heatwright.generator.plan.settings import settings as plan_settings
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.text import c_comment
from heatwright.spec import Spec, facts_of
from heatwright.spec.board.timers import TimerUse, allocate
from heatwright.spec.problems import Path
from heatwright.spec.registry import module_of

_T = TypeVar("_T")


def plan_firmware(spec: Spec) -> Plan:
    """Decide the firmware of `spec`: every file, constant, register and call."""
    root = Source(spec, ())
    controller = spec.controller
    use = allocate(controller)
    loops = [summary(root.at("loops", name), name) for name in controller.loops]
    clock, gate = core.clock(root, use.tick), core.gate(root, loops, list(use.steppers))
    settings = plan_settings(root, loops)
    sensors = [_sensor(root, name, use.one_wire.get(name)) for name in controller.sensors]
    outputs = [_output(root, name, use) for name in controller.outputs]
    proofs, inputs = plan_proofs(root), plan_inputs(root)
    interfaces = [
        import_module(module_of("interface", "plan", interface.kind)).plan(
            root.at("interfaces", index), interface
        )
        for index, interface in enumerate(controller.interfaces)
    ]
    control = [
        plan_loop(root.at("loops", name), name, loop) for name, loop in controller.loops.items()
    ]
    owned: list[tuple[Path, Part]] = [
        *(
            ((), part)
            for part in (core.start(root, _each(part.reset_lines for part in outputs)), clock, gate)
        ),
        ((), core.fault(root, loops)),
        *((("safety", "self_checks"), part) for part in plan_checks(root)),
        *zip((("outputs", name) for name in controller.outputs), outputs, strict=True),
        *zip((("sensors", name) for name in controller.sensors), sensors, strict=True),
        *zip((("loops", name) for name in controller.loops), control, strict=True),
        *((("interfaces", index), part) for index, part in enumerate(interfaces)),
        ((), settings),
        *((("outputs",), part) for part in proofs),
        *((("safety", "inputs"), part) for part in inputs),
        (("programs",), plan_programs(root)),
        *(
            (("programs",), part)
            for part in (program.plan(root, each) for each in loops if each.programmed)
        ),
    ]
    parts = [part for _, part in owned]
    files = (
        *project_files(spec, [*sensors, *outputs, *proofs, *inputs, *interfaces]),
        *_shared_files(spec, parts),
        *(file for part in parts for file in part.files),
    )
    return Plan(
        name=controller.identity.name,
        banner=f"{MARK} from {c_comment(spec.file_name)}: edit that file, not this one. "
        "SPDX-License-Identifier: MIT-0",
        files=_unique(files),
        owners=_owners(owned),
        wiring={path: part.wiring for path, part in owned if path and part.wiring},
    )


def _owners(owned: list[tuple[Path, Part]]) -> dict[str, tuple[Path, ...]]:
    """Find the keys of the spec that need each file; none for a file of every firmware."""
    found: dict[str, tuple[Path, ...]] = {}
    for path, part in owned:
        for file in part.files:
            key = (*path, *file.key)
            found[file.path] = tuple(dict.fromkeys((*found.get(file.path, ()), key)))
    return {path: () if () in keys else keys for path, keys in found.items()}


@dataclass(frozen=True, slots=True)
class ConfigNames:
    """The values for the template of config.h."""

    spec_file: str
    digest: str
    clock_hz: int
    clock_mhz: str
    mcu_macro: str
    mcu_name: str
    groups: list[Group]


@dataclass(frozen=True, slots=True)
class PinsNames:
    """The values for the template of pins.h."""

    pins: list[PinPlan]
    atomic_pins: bool


@dataclass(frozen=True, slots=True)
class MainNames:
    """The values for the template of main.c."""

    title: str
    tick_ms: int
    main_includes: list[Header]
    start_calls: list[Call]
    tick_calls: list[Call]
    checked: bool
    watchdog: str


def _shared_files(spec: Spec, parts: list[Part]) -> tuple[File, ...]:
    """The files to which several parts add: config.h, pins.h, main.c."""
    board = spec.controller.board
    config = ConfigNames(
        spec_file=c_comment(spec.file_name),
        digest=spec.digest,
        clock_hz=board.clock_hz,
        clock_mhz=f"{board.clock_hz / 1e6:g}",
        mcu_macro=board.macro,
        mcu_name=board.mcu,
        groups=_each(part.groups for part in parts),
    )
    pins = _each(part.pins for part in parts)
    atomic = any(function.atomic for pin in pins for function in pin.functions)
    start, tick = (
        sorted(_each(calls), key=lambda call: call.stage)
        for calls in ((part.start_calls for part in parts), (part.tick_calls for part in parts))
    )
    main = MainNames(
        title=c_comment(spec.controller.identity.title or spec.controller.identity.name),
        tick_ms=TICK_MS,
        main_includes=_includes([*start, *tick]),
        start_calls=start,
        tick_calls=tick,
        checked=facts_of(spec.controller).checked,
        watchdog=f"WDTO_{core.WATCHDOG_NAMES[spec.controller.safety.watchdog_s]}",
    )
    return (
        File("src/config.h", "core/config.h.j2", config),
        File("src/pins.h", "core/pins.h.j2", PinsNames(pins, atomic)),
        File("src/main.c", "core/main.c.j2", main),
    )


def _each(added: Iterable[tuple[_T, ...]]) -> list[_T]:
    """Return the entries of all parts, each once: several parts may share a helper."""
    return list(dict.fromkeys(chain.from_iterable(added)))


def _includes(calls: list[Call]) -> list[Header]:
    """Return each header once, with the functions for which main.c includes it."""
    functions: dict[str, list[str]] = {"clock.h": ["clock_wait"]}
    for call in calls:
        if call.header:
            functions.setdefault(call.header, []).append(call.text.partition("(")[0])
    return [
        Header(header, ", ".join(dict.fromkeys(functions[header]))) for header in sorted(functions)
    ]


def _unique(files: Iterable[File]) -> tuple[File, ...]:
    """Return each file once: several parts may share a helper."""
    by_path: dict[str, File] = {}
    for file in files:
        by_path.setdefault(file.path, file)
    return tuple(by_path[path] for path in sorted(by_path))


def _sensor(root: Source, name: str, timer: int | None) -> Part:
    sensor, use = root.controller.sensors[name], use_of(root.controller, name, timer)
    module = import_module(module_of("sensor", "plan", sensor.kind))
    part: Part = module.plan(root.at("sensors", name), name, sensor, use)
    return part


def _output(root: Source, name: str, timers: TimerUse) -> Part:
    output = root.controller.outputs[name]
    if name == root.controller.safety.relay:
        return relay.plan(root, name)
    heats = any(loop.heater == name for loop in root.controller.loops.values())
    host = facts_of(root.controller).gcode
    use = UseOfOutput(
        heats,
        commanded=host is not None and name in host.fans.values(),
        channel=timers.pwm.get(name),
        timer=timers.steppers.get(name),
        cools=cools(root.controller, name),
        watched=watched(root.controller, name),
    )
    module = import_module(module_of("output", "plan", output.kind))
    part: Part = module.plan(root.at("outputs", name), name, output, use)
    return part
