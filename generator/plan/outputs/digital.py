"""Digital outputs: heaters switched by on-off control, and fans."""

from __future__ import annotations

from heatwright.generator.plan.outputs.common import (
    UseOfOutput,
    heater_part,
    output_context,
    wiring,
)
from heatwright.generator.plan.parts import Call, File, Part, Stage
from heatwright.generator.plan.pins import switched
from heatwright.generator.plan.source import Source
from heatwright.spec import DigitalOutput


def plan(source: Source, name: str, output: DigitalOutput, use: UseOfOutput) -> Part:
    """Plan a heater, or a fan that runs always."""
    if use.heats:
        return heater_part(source, name, output, "outputs/digital")
    context = output_context(source, name) | {"runs_where": source.at("runs").where}
    pin = source.controller.board.pins[output.pin]
    return Part(
        files=(
            File(f"src/output_{name}.h", "outputs/digital.h.j2", context),
            File(f"src/output_{name}.c", "outputs/digital.c.j2", context),
        ),
        pins=(switched(source.at("pin"), f"output_{name}", pin, output.active, f"output {name}"),),
        start_calls=(Call(Stage.SENSE, f"output_{name}.h", f"output_{name}_start();"),),
        wiring=(wiring(source, name, output),),
    )
