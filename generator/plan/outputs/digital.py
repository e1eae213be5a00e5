"""Digital outputs: heaters switched by on-off control, coolers, and fans."""

from __future__ import annotations

from heatwright.generator.plan.numbers import TICK_MS, milliseconds, quantity
from heatwright.generator.plan.outputs.common import UseOfOutput, output_part, stops
from heatwright.generator.plan.parts import Call, Constant, Part, Stage
from heatwright.generator.plan.source import Source
from heatwright.spec import DigitalOutput

MOST_OF_16_BITS = 65535


def plan(source: Source, name: str, output: DigitalOutput, use: UseOfOutput) -> Part:
    """Plan a heater, a cooler, a fan that runs always, or one that the host commands."""
    start = Call(Stage.SENSE, f"output_{name}.h", f"output_{name}_start();")
    if output.minimum_on_s > 0 or output.minimum_off_s > 0:
        return _held(source, name, output, use, () if use.gated else (start,))
    return output_part(
        source,
        name,
        output,
        use,
        "outputs/digital",
        context={"runs_where": source.at("runs").where},
        start_calls=() if use.gated else (start,),
    )


def _held(
    source: Source, name: str, output: DigitalOutput, use: UseOfOutput, start: tuple[Call, ...]
) -> Part:
    """Plan an output that stays on, and off, for a while at least."""
    least = {"minimum_on": output.minimum_on_s, "minimum_off": output.minimum_off_s}
    in_ticks = {key: _at_least(duration_s) for key, duration_s in least.items()}
    tick = Call(Stage.STORE, f"output_{name}.h", f"output_{name}_tick(true);")
    return output_part(
        source,
        name,
        output,
        use,
        "outputs/held",
        constants=tuple(
            _least(source.at(key), f"OUTPUT_{name}_{key}_TICKS".upper(), in_ticks[key], duration_s)
            for key, duration_s in least.items()
        ),
        context={
            "ticks_type": "uint16_t" if max(in_ticks.values()) <= MOST_OF_16_BITS else "uint32_t",
            "stops": stops(source.controller, name),
        },
        start_calls=start,
        tick_calls=() if use.gated else (tick,),
        wired="".join(
            f", {key.removeprefix('minimum_')} for {quantity(duration_s, 's')} at least"
            for key, duration_s in least.items()
            if duration_s > 0
        ),
    )


def _least(source: Source, name: str, ticks: int, duration_s: float) -> Constant:
    return source.count(name, ticks, f"{quantity(duration_s, 's')} at least")


def _at_least(duration_s: float) -> int:
    """Whole ticks, rounded up: a minimum must not be shorter."""
    return -(-milliseconds(duration_s) // TICK_MS)
