"""Digital outputs: heaters switched by on-off control, and fans."""

from __future__ import annotations

from heatwright.generator.plan.outputs.common import UseOfOutput, output_part
from heatwright.generator.plan.parts import Call, Part, Stage
from heatwright.generator.plan.source import Source
from heatwright.spec import DigitalOutput


def plan(source: Source, name: str, output: DigitalOutput, use: UseOfOutput) -> Part:
    """Plan a heater, a fan that runs always, or one that the host commands."""
    start = Call(Stage.SENSE, f"output_{name}.h", f"output_{name}_start();")
    return output_part(
        source,
        name,
        output,
        use,
        "outputs/digital",
        context={"runs_where": source.at("runs").where},
        start_calls=() if use.heats else (start,),
    )
