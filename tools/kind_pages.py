# SPDX-License-Identifier: GPL-3.0-or-later
"""The site's page of each kind: wiring, keys, what fails and what trips, an example.

All of it is made from the models, the plan of a firmware, and the catalogue of faults, for the
shortest of the examples that has the kind.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import yaml

from heatwright.generator import plan_firmware
from heatwright.generator.plan.parts import Wiring
from heatwright.generator.plan.protection.hazards import hazards
from heatwright.generator.wiring import drawn
from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.binary.elf import Elf
from heatwright.sim.faults.catalogue import by_part
from heatwright.sim.faults.fault import Fault
from heatwright.sim.faults.world import Site
from heatwright.sim.plots.plot import run_figure
from heatwright.sim.scenario import long_enough
from heatwright.spec import RULES, Controller, Spec, load
from heatwright.spec.boards import BOARDS, Board

CODES = {rule.id: rule.code for rule in RULES.values()}
PARTS = {
    "sensor": ("sensor", "tip"),
    "output": ("heater", "wire", "cooler"),
    "algorithm": ("effort", "program"),
    "interface": ("display", "operator", "master"),
    "board": ("processor", "memory"),
    "plant": ("fan", "tip", "heater"),
}
"""The parts of the catalogue of faults that concern a role."""
HAZARDS = {
    "sensor": r"sensor|reading",
    "output": r"heater|relay",
    "algorithm": r"heater's switch|reading stands|Heater, fuse",
    "interface": r"host|master|Nobody|nobody",
    "board": r"program|processor|supply breaks|chip|clock|ADC|bit of RAM",
    "plant": r"falls out|drifts|leaks|fan|part",
}
"""The causes of a project's table of hazards that concern a role."""


RUN = ("algorithm", "plant")
"""Roles of what no wire leads to: a run shows what they do."""


@dataclass(frozen=True)
class Use:
    """Where an example has a kind: the path of its entry, and the loop that it serves."""

    spec: Spec
    file: Path
    path: tuple[str | int, ...]
    loop: str


def uses(folder: Path) -> dict[tuple[str, str], Use]:
    """Find each role and kind in the shortest example that has it."""
    files = sorted(folder.glob("*.yaml"), key=lambda file: (len(file.read_bytes()), file.name))
    found: dict[tuple[str, str], Use] = {}
    for file in files:
        spec = load(file)
        for role, kind, path, loop in _entries(spec.controller):
            found.setdefault((role, kind), Use(spec, file, path, loop))
    return found


def _entries(controller: Controller) -> Iterator[tuple[str, str, tuple[str | int, ...], str]]:
    first = next(iter(controller.loops))
    loops = controller.loops.items()
    for name, sensor in controller.sensors.items():
        mine = next((loop for loop, each in loops if each.sensor == name), first)
        yield "sensor", sensor.kind, ("sensors", name), mine
    for name, output in controller.outputs.items():
        mine = next((loop for loop, each in loops if name in {each.heater, each.cooler}), first)
        yield "output", output.kind, ("outputs", name), mine
    for name, loop in loops:
        yield "algorithm", loop.algorithm.kind, ("loops", name, "algorithm"), name
    for number, interface in enumerate(controller.interfaces):
        yield "interface", interface.kind, ("interfaces", number), first
    if controller.simulation is not None:
        yield "plant", controller.simulation.plant.kind, ("simulation", "plant"), first
    yield "board", controller.identity.board, ("controller",), first


def page(
    role: str, kind: str, use: Use | None, keys: Mapping[str, Any] | None, program: Elf
) -> tuple[str, dict[str, bytes]]:
    """Return a page, and its picture by file name; keys -- the kind's part of the schema."""
    parts = [f"# {kind}", keys["description"] if keys else _board(BOARDS[kind])]
    pictures = {}
    if use is not None:
        rows = plan_firmware(use.spec).wiring.get(use.path, ())
        if rows:
            parts.append(f"## Wiring\n\n![{kind} at its board]({kind}.svg)\n\n{_wires(rows)}")
            drawing = drawn(kind, use.spec.controller.identity.board, rows, ())
            pictures[f"{kind}.svg"] = drawing.encode()
        elif role in RUN:
            parts.append(
                f"## A run\n\n![Temperature, setpoint and duty with {kind}]({kind}.png)\n\n"
                f"The reference model on the machine of `{use.file.stem}`, through its scenario."
            )
            pictures[f"{kind}.png"] = _run(use)
    if keys is not None:
        parts.append(f"## Keys\n\n{_keys(keys)}")
    parts += _failing(role, use, program) if use is not None else []
    parts.append(_example(use) if use is not None else "## Example\n\nNo example has it.")
    return "\n\n".join(parts) + "\n", pictures


def _run(use: Use) -> bytes:
    """Draw a run of the example."""
    controller = use.spec.controller
    picture = BytesIO()
    trace = bench(long_enough(controller), ReferenceDevice(controller))
    run_figure(trace, controller).savefig(picture, format="png")
    return picture.getvalue()


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _wires(rows: Sequence[Wiring]) -> str:
    return _table(("pin", "what", "how"), [(row.pin, row.what, row.how) for row in rows])


def _keys(definition: Mapping[str, Any]) -> str:
    rows = [
        (f"`{key}`", _default(key, each, definition), each.get("description", ""))
        for key, each in definition["properties"].items()
        if key != "kind"
    ]
    if not rows:
        return "It has no keys."
    told = "[The language](../docs/language.md) tells which values a key takes."
    return _table(("key", "default", "meaning"), rows) + f"\n\n{told}"


def _default(key: str, described: Mapping[str, Any], definition: Mapping[str, Any]) -> str:
    if key in definition.get("required", ()):
        return "needed"
    return f"`{json.dumps(described['default'])}`" if "default" in described else "none"


def _board(board: Board) -> str:
    flash = board.flash_bytes - board.bootloader_bytes
    rows = [
        ("chip", board.mcu),
        (
            "flash for a firmware, RAM, EEPROM",
            f"{flash}, {board.ram_bytes}, {board.eeprom_bytes} bytes",
        ),
        ("serial ports", ", ".join(f"{each.rx}/{each.tx}" for each in board.uarts)),
        ("takes a shield", "yes" if board.shield else "no"),
        ("boot loader", "none" if board.bootloader_talks is None else board.bootloader_talks[0]),
    ]
    return _table(("what", "it has"), rows)


def _failing(role: str, use: Use, program: Elf) -> list[str]:
    """Describe the faults that `verify` tries, and the hazards of such a machine."""
    controller = use.spec.controller
    found = _faults(role, use, program)
    rows = [(f"`{fault.id}`", _follows(fault)) for fault in found]
    parts = ["## What fails, and what trips"]
    if rows:
        parts += [
            f"`verify` tries these on `{use.file.stem}`:",
            _table(("fault", "what must follow"), rows),
        ]
    else:
        parts.append("The catalogue has no fault of it alone.")
    harmful = [
        (
            each.cause,
            each.seen,
            each.remains.replace(
                "heatwright's `docs/safety.md`", "see [safety](../docs/safety.md)"
            ),
        )
        for each in hazards(controller)
        if re.search(HAZARDS[role], each.cause)
    ]
    if harmful:
        parts += [
            "By which codes a machine like this one tells it, how long after the condition begins "
            "the heaters are off at the latest, and what remains:",
            _table(("cause", "seen by, within", "what remains"), harmful),
        ]
    codes = sorted({int(code) for code in re.findall(r"E(\d\d)\b", "".join(parts))})
    if codes:
        named = "; ".join(f"E{code:02d} {RULES[code].meaning.rstrip('.')}" for code in codes)
        parts.append(f"The codes: {named}.")
    return parts


def _faults(role: str, use: Use, program: Elf) -> list[Fault]:
    controller = use.spec.controller
    found = _of_parts(role, Site(controller, use.loop, program))
    if role != "interface":
        return found
    others = tuple(
        each for number, each in enumerate(controller.interfaces) if number != use.path[1]
    )
    without = controller.model_copy(update={"interfaces": others})
    known = {fault.id for fault in _of_parts(role, Site(without, use.loop, program))}
    return [fault for fault in found if fault.id not in known]


def _of_parts(role: str, site: Site) -> list[Fault]:
    """The program is looked at for the faults of memory alone."""
    parts = by_part(site)
    return [fault for part in PARTS[role] for fault in parts.get(part, ())]


def _follows(fault: Fault) -> str:
    if fault.trip is not None and fault.trip.rules:
        codes = [f"E{CODES[rule]:02d}" for rule in fault.trip.rules]
        told = ", ".join(codes[:-1]) + " or " * (len(codes) > 1) + codes[-1]
        return f"{told}, within {round(fault.trip.allowed_s, 2):g} s"
    if fault.calm:
        return "nothing trips, for the machine is well"
    return "the rule that the reference model meets first, in the same step"


def _example(use: Use) -> str:
    """Cut the entry out of its example, as it is written there."""
    text = use.file.read_text(encoding="utf-8")
    node: Any = yaml.compose(text, yaml.CSafeLoader)
    lines = text.splitlines()
    start, heads = node.start_mark.line, []
    for key in use.path:
        if isinstance(key, int):
            node = node.value[key]
            start = node.start_mark.line
        else:
            name, node = next(pair for pair in node.value if pair[0].value == key)
            start = name.start_mark.line
        heads.append(start)
    end = max(node.end_mark.line, start + (node.end_mark.column > 0))
    shown = [lines[line] for line in dict.fromkeys(heads[:-1])] + lines[start:end]
    while shown and not shown[-1].strip():
        shown.pop()
    link = f"[{use.file.stem}](../spec/examples/{use.file.stem}.md)"
    code = "\n".join(shown)
    return f"## Example\n\nFrom {link}:\n\n```yaml\n{code}\n```"
