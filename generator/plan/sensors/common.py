"""Common parts of the plans of all sensors."""

from dataclasses import dataclass

from heatwright.generator.plan.numbers import TICK_MS
from heatwright.generator.plan.parts import Constant
from heatwright.generator.plan.source import Source
from heatwright.spec import Controller, Loop, facts_of
from heatwright.spec.sensors import Thermometer


@dataclass(frozen=True, slots=True)
class UseOfSensor:
    """How the firmware uses a sensor."""

    loop: Loop
    """The loop with the shortest period of those that read the sensor, also for a monitor."""
    timer: int | None
    """Number of its own timer; None for a sensor that needs none."""


def summed(source: Source, prefix: str, oversample: int, use: UseOfSensor) -> tuple[Constant, ...]:
    """Return constants: the ADC codes in a reading, and the ticks to wait before the first code."""
    spare = max(0, use.loop.period_ticks - oversample - 1)
    last = f"the last {oversample * TICK_MS} ms before the step"
    return (
        source.at("oversample").count(f"{prefix}_OVERSAMPLE", oversample, "codes in a reading"),
        Constant(f"{prefix}_START_TICKS", f"{spare}u", f"wait: the reading covers {last}"),
    )


def raw_type(sensor: Thermometer) -> str:
    """Name the C type of a thermometer's readings."""
    return f"int{sensor.reading_bits}_t"


def use_of(controller: Controller, name: str, timer: int | None) -> UseOfSensor:
    """Find the loop that reads a sensor most often; `timer` is the sensor's own timer."""
    loops = (
        controller.loops[loop.name]
        for loop in facts_of(controller).loops.values()
        if name == loop.sensor
        or (loop.current and name == loop.current.sensor)
        or any(name == each.sensor for each in loop.monitored.values())
    )
    return UseOfSensor(min(loops, key=lambda loop: loop.period_ticks), timer)
