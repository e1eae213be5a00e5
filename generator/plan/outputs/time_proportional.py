"""Time-proportional outputs: on for a share of a window, counted in ticks."""

from dataclasses import dataclass

from heatwright.generator.plan.numbers import milliseconds, quantity, ticks
from heatwright.generator.plan.outputs.common import UseOfOutput, output_part
from heatwright.generator.plan.parts import Constant, Part
from heatwright.generator.plan.source import Source
from heatwright.spec import TimeProportionalOutput

UINT8_MAX = 0xFF


@dataclass(frozen=True, slots=True)
class WindowNames:
    """Further values for the templates."""

    minimum_on: bool
    minimum_off: bool
    spread: bool
    step_type: str
    tick_type: str
    distribution_where: str


def plan(source: Source, name: str, output: TimeProportionalOutput, use: UseOfOutput) -> Part:
    """Plan a heater that is switched by the tick."""
    prefix = f"OUTPUT_{name.upper()}"
    resolution_ms = milliseconds(output.resolution_s)

    def in_steps(duration_s: float) -> int:
        return milliseconds(duration_s) // resolution_ms

    def least(key: str, duration_s: float) -> Constant:
        name, shown = f"{prefix}_{key.upper()}_STEPS", quantity(duration_s, "s")
        return source.at(key).count(name, in_steps(duration_s), shown)

    spread = output.distribution == "spread"
    window = in_steps(output.window_s)
    windows = source.at("window").count(
        f"{prefix}_WINDOW_STEPS",
        window,
        f"{quantity(output.window_s, 's')} in steps of {resolution_ms} ms",
    )
    in_ticks = source.at("window").ticks(f"{prefix}_WINDOW_TICKS", output.window_s)
    constants = [
        windows if spread else in_ticks,
        source.at("resolution").count(
            f"{prefix}_TICKS_PER_STEP", ticks(output.resolution_s), f"{resolution_ms} ms"
        ),
        source.at("window").number(
            f"{prefix}_STEPS_PER_PERCENT", window / 100, f"{window} / 100 %"
        ),
    ]
    if output.minimum_on_s > 0:
        constants.append(least("minimum_on", output.minimum_on_s))
    if output.minimum_off_s > 0:
        constants += [windows, least("minimum_off", output.minimum_off_s)]
    return output_part(
        source,
        name,
        output,
        use,
        "outputs/time_proportional",
        constants=tuple(constants),
        told=WindowNames(
            minimum_on=output.minimum_on_s > 0,
            minimum_off=output.minimum_off_s > 0,
            spread=spread,
            step_type=_smallest(window),
            tick_type=_smallest(ticks(output.resolution_s)),
            distribution_where=source.at("distribution").where,
        ),
    )


def _smallest(most: int) -> str:
    """Return the C type that counts up to this number with the fewest cycles."""
    return "uint8_t" if most <= UINT8_MAX else "uint16_t"
