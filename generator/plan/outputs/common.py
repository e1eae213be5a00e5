"""What the plans of all outputs share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Wiring
from heatwright.generator.plan.pins import label, switched
from heatwright.generator.plan.source import Source
from heatwright.spec import Output


@dataclass(frozen=True, slots=True)
class UseOfOutput:
    """What the loops do with an output."""

    heats: bool
    """True if it is the heater of a loop, so that the gate switches it."""
    commanded: bool
    """True if the host switches it: a fan of a `gcode` interface."""


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
        wiring=(wiring(source, name, output),),
    )


def wiring(source: Source, name: str, output: Output) -> Wiring:
    """Say how an output of one pin is connected."""
    power = f", {quantity(output.power_w, 'W')}" if output.power_w is not None else ""
    pull = "down" if output.active == "high" else "up"
    return Wiring(
        label(source.controller.board.pins[output.pin]),
        f"output `{name}`: {output.kind}{power}",
        f"active {output.active}; 10 kΩ pull it {pull} while the chip is in reset",
    )
