"""What the plans of all outputs share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from heatwright.generator.plan.parts import Call, Constant, File, Group, Part
from heatwright.generator.plan.pins import switched
from heatwright.generator.plan.source import Source
from heatwright.spec import Output


@dataclass(frozen=True, slots=True)
class UseOfOutput:
    """What the loops do with an output."""

    heats: bool
    """True if it is the heater of a loop, so that the gate switches it."""


def output_context(source: Source, name: str) -> dict[str, Any]:
    """Names that every output's template uses."""
    return {
        "name": name,
        "NAME": name.upper(),
        "prefix": f"OUTPUT_{name.upper()}",
        "where": source.where,
        "heats": False,
    }


def heater_part(  # noqa: PLR0913 - one part, said once
    source: Source,
    name: str,
    output: Output,
    template: str,
    *,
    constants: tuple[Constant, ...] = (),
    context: dict[str, Any] | None = None,
    start_calls: tuple[Call, ...] = (),
) -> Part:
    """Plan an output that the gate switches."""
    merged = output_context(source, name) | {"heats": True} | (context or {})
    pin = source.controller.board.pins[output.pin]
    return Part(
        files=(
            File(f"src/output_{name}.h", f"{template}.h.j2", merged),
            File(f"src/output_{name}.c", f"{template}.c.j2", merged),
        ),
        groups=(Group(f"Output {name}", constants),) if constants else (),
        pins=(switched(source.at("pin"), f"output_{name}", pin, output.active, f"output {name}"),),
        start_calls=start_calls,
    )
