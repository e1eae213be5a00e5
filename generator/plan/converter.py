"""Common parts of thermocouple converters on three wires: pins, a reader, and its times."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from heatwright.generator.plan.numbers import TICK_MS, quantity, told_period
from heatwright.generator.plan.parts import (
    Call,
    Constant,
    Group,
    Part,
    Stage,
    Symbol,
    Wiring,
    along,
    pair,
    pulled,
)
from heatwright.generator.plan.pins import driven, label, lifted
from heatwright.generator.plan.sensors.common import UseOfSensor, raw_type
from heatwright.generator.plan.source import Source
from heatwright.spec import Max6675, Max31855
from heatwright.spec.boards import Pin


@dataclass(frozen=True, slots=True)
class Chip:
    """Data of a converter, from its data sheet."""

    name: str
    supply: str
    """The chip's supply, and other parts that must be connected."""
    shift: str = ""
    """The level shifter, if the chip's levels differ from the board's."""
    power_up_s: float = 0.0
    """Time from the power-up to the first conversion, s."""


@dataclass(frozen=True, slots=True)
class ConverterNames:
    """The values for the templates of a converter, in addition to its name."""

    chip: str
    select: str
    clock: str
    data: str
    step: str
    raw: str


def plan_converter(
    source: Source, name: str, sensor: Max6675 | Max31855, use: UseOfSensor, chip: Chip
) -> Part:
    """Plan a converter and the reader of its wires."""
    pins = source.controller.board.pins
    select, clock, data = (
        pins[each] for each in (sensor.chip_select, sensor.clock, sensor.data_out)
    )
    names = label(select), label(clock), label(data)
    wires = ConverterNames(chip.name, *names, quantity(sensor.step_k, "K"), raw_type(sensor))
    told = source.named(name), wires
    of_sensor = f"of sensor {name}"
    return Part(
        files=(
            *pair(f"spi_{name}", "peripherals/spi", told),
            *pair(f"sensor_{name}", f"sensors/{sensor.kind}", told),
        ),
        groups=(Group(f"Sensor {name}", _constants(source, sensor, name, use, chip)),),
        pins=(
            driven(source.at("chip_select"), f"sensor_{name}_select", select, f"CS {of_sensor}"),
            driven(source.at("clock"), f"sensor_{name}_clock", clock, f"SCK {of_sensor}"),
            lifted(source.at("data_out"), f"sensor_{name}_data", data, f"SO {of_sensor}"),
        ),
        start_calls=(Call(Stage.SENSE, f"spi_{name}.h", f"spi_{name}_start();"),),
        tick_calls=(Call(Stage.SENSE, f"sensor_{name}.h", f"sensor_{name}_tick();"),),
        wiring=wiring(name, chip, {"CS": select, "SCK": clock, "SO": data}),
    )


def wiring(name: str, chip: Chip, pins: Mapping[str, Pin]) -> tuple[Wiring, ...]:
    """Describe how a converter is connected.

    pins -- the board's pins by the converter's terminals, in the order select, inputs, output.
    """
    what = f"sensor `{name}`: {chip.name}"
    (select, select_pin), *inputs, (output, output_pin) = pins.items()
    return (
        Wiring(
            label(select_pin),
            what,
            f"{select}{chip.shift}; 10 kΩ to its supply",
            (*shifted(chip.shift), pulled("up", rail=chip.supply.partition(",")[0])),
            select,
        ),
        *(
            Wiring(label(pin), what, f"{end}{chip.shift}", shifted(chip.shift), end)
            for end, pin in inputs
        ),
        Wiring(
            label(output_pin),
            what,
            f"{output}; nothing else may drive or pull this line",
            end=output,
        ),
        Wiring("–", what, chip.supply),
    )


def shifted(shift: str) -> tuple[Symbol, ...]:
    """Draw a level shifter if there is one."""
    return (along("level shifter"),) if shift else ()


def _constants(
    source: Source, sensor: Max6675 | Max31855, name: str, use: UseOfSensor, chip: Chip
) -> tuple[Constant, ...]:
    prefix = f"SENSOR_{name.upper()}"
    first_s = chip.power_up_s + sensor.conversion_s
    return (
        Constant(
            f"{prefix}_STEP_C", f"{sensor.step_k:g}f", f"{source.where}: one step of the reading"
        ),
        Constant(
            f"{prefix}_PERIOD_TICKS",
            f"{use.loop.period_ticks}u",
            f"read every {told_period(use.loop)}, in the tick of the step",
        ),
        Constant(
            f"{prefix}_POWER_UP_TICKS",
            f"{math.ceil(round(first_s * 1000) / TICK_MS)}u",
            f"the first conversion ends at most {quantity(first_s * 1000, 'ms')} after power-up "
            "(data sheet)",
        ),
    )
