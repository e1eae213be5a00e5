"""Digital outputs: heaters switched by on-off control, coolers, and fans."""

from __future__ import annotations

from heatwright.generator.plan.numbers import quantity, ticks
from heatwright.generator.plan.outputs.common import UseOfOutput, output_part
from heatwright.generator.plan.parts import Call, Constant, Part, Stage
from heatwright.generator.plan.source import Source
from heatwright.spec import DigitalOutput


def plan(source: Source, name: str, output: DigitalOutput, use: UseOfOutput) -> Part:
    """Plan a heater, a cooler, a fan that always runs, or one that the host commands."""
    start = Call(Stage.SENSE, f"output_{name}.h", f"output_{name}_start();")
    if output.is_held:
        return _held(source, name, output, use, () if use.gated else (start,))
    return output_part(
        source,
        name,
        output,
        use,
        "outputs/digital",
        told={"runs_where": source.at("runs").where},
        start_calls=() if use.gated else (start,),
    )


def _held(
    source: Source, name: str, output: DigitalOutput, use: UseOfOutput, start: tuple[Call, ...]
) -> Part:
    """Plan an output with a minimum on or off time."""
    least = {"minimum_on": output.minimum_on_s, "minimum_off": output.minimum_off_s}
    tick = Call(Stage.STORE, f"output_{name}.h", f"output_{name}_tick(true);")
    return output_part(
        source,
        name,
        output,
        use,
        "outputs/held",
        constants=tuple(
            _least(source.at(key), f"OUTPUT_{name}_{key}_TICKS".upper(), duration_s)
            for key, duration_s in least.items()
        ),
        told={"stops": use.heats and output.stays_on_s > 0},
        start_calls=start,
        tick_calls=() if use.gated else (tick,),
        wired="".join(
            f", {key.removeprefix('minimum_')} for {quantity(duration_s, 's')} at least"
            for key, duration_s in least.items()
            if duration_s > 0
        ),
    )


def _least(source: Source, name: str, duration_s: float) -> Constant:
    return source.count(name, ticks(duration_s), f"{quantity(duration_s, 's')} at least")
