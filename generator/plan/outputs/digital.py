"""Digital outputs: heaters switched by on-off control, coolers, and fans."""

from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.outputs.common import UseOfOutput, output_part
from heatwright.generator.plan.parts import Call, Part, Stage
from heatwright.generator.plan.source import Source
from heatwright.spec import DigitalOutput
from heatwright.spec.outputs import is_held


def plan(source: Source, name: str, output: DigitalOutput, use: UseOfOutput) -> Part:
    """Plan a heater, a cooler, a fan that always runs, or one that the host commands."""
    start = Call(Stage.SENSE, f"output_{name}.h", f"output_{name}_start();")
    starts = () if use.gated else (start,)
    if is_held(output):
        return _held(source, name, output, use, starts)
    return output_part(source, name, output, use, "outputs/digital", start_calls=starts)


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
            source.at(key).ticks(f"OUTPUT_{name}_{key}_TICKS".upper(), duration_s, " at least")
            for key, duration_s in least.items()
        ),
        start_calls=start,
        tick_calls=() if use.gated else (tick,),
        wired="".join(
            f", {key.removeprefix('minimum_')} for {quantity(duration_s, 's')} at least"
            for key, duration_s in least.items()
            if duration_s > 0
        ),
    )
