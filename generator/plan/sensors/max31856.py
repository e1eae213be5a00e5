"""MAX31856: a thermocouple of any type, 19 bit, with registers on four wires."""

import math
from dataclasses import dataclass

from heatwright.generator.plan.converter import Chip, ConverterNames, wiring
from heatwright.generator.plan.numbers import TICK_MS, quantity, told_period
from heatwright.generator.plan.parts import Call, Constant, Group, Part, Stage, pair
from heatwright.generator.plan.pins import FAR_PORTS, driven, label, lifted
from heatwright.generator.plan.sensors.common import UseOfSensor, raw_type
from heatwright.generator.plan.source import Source
from heatwright.spec import Max31856, facts_of
from heatwright.spec.sensing.max31856 import TYPE_CODES

OPEN_TEST = 0x10
"""CR0, OCFAULT: test for an open thermocouple, for less than 5 kΩ in its wires."""
FIFTY_HZ = 0x01
REGISTERS, NEAR_A_TICK, FAR_A_TICK = 16, 4, 3
"""Both numbers per tick divide 12, the number of registers before the temperature."""
AVERAGING_AT = 4
"""Lowest bit of CR1's AVGSEL: the power of two of the averaged conversions."""
SHIFT = " through a level shifter to 3.3 V"
SUPPLY = "3.3 V, with 100 nF; T+ and T- with 100 nF between them and 10 nF each to ground"


@dataclass(frozen=True, slots=True)
class RegisterNames:
    """Further values for the templates of a MAX31856."""

    data_in: str
    selectable: bool
    selectable_where: str
    users: list[str]
    programmed: bool


def plan(source: Source, name: str, sensor: Max31856, use: UseOfSensor) -> Part:
    """Plan the sensor and the wires to its registers."""
    pins = source.controller.board.pins
    wires = sensor.chip_select, sensor.clock, sensor.data_in, sensor.data_out
    select, clock, data_in, data = (pins[each] for each in wires)
    terminals = {"CS": select, "SCK": clock, "SDI": data_in, "SDO": data}
    loops = source.controller.loops
    users = [user for user, loop in loops.items() if loop.sensor == name]
    names = label(select), label(clock), label(data)
    chip = ConverterNames("MAX31856", *names, quantity(sensor.step_k, "K"), raw_type(sensor))
    registers = RegisterNames(
        data_in=label(data_in),
        selectable=bool(sensor.selectable),
        selectable_where=source.at("selectable").where,
        users=users,
        programmed=any(facts_of(source.controller, user).programmed for user in users),
    )
    context = source.named(name), chip, registers
    of_sensor = f"of sensor {name}"
    return Part(
        files=(
            *pair(f"spi_{name}", "peripherals/spi_registers", context),
            *pair(f"sensor_{name}", "sensors/max31856", context),
        ),
        groups=(Group(f"Sensor {name}", _constants(source, name, sensor, use)),),
        pins=(
            driven(source.at("chip_select"), f"sensor_{name}_select", select, f"CS {of_sensor}"),
            driven(source.at("clock"), f"sensor_{name}_clock", clock, f"SCK {of_sensor}"),
            driven(source.at("data_in"), f"sensor_{name}_data_in", data_in, f"SDI {of_sensor}"),
            lifted(source.at("data_out"), f"sensor_{name}_data", data, f"SDO {of_sensor}"),
        ),
        start_calls=(Call(Stage.SENSE, f"spi_{name}.h", f"spi_{name}_start();"),),
        tick_calls=(Call(Stage.SENSE, f"sensor_{name}.h", f"sensor_{name}_tick();"),),
        wiring=wiring(name, Chip("MAX31856", SUPPLY, SHIFT), terminals),
    )


def _constants(
    source: Source, name: str, sensor: Max31856, use: UseOfSensor
) -> tuple[Constant, ...]:
    prefix = f"SENSOR_{name.upper()}"
    mains, average = source.at("mains_filter"), source.at("average")
    settings = OPEN_TEST | (FIFTY_HZ if sensor.mains_filter_hz == 50.0 else 0)
    wires = sensor.chip_select, sensor.clock, sensor.data_in, sensor.data_out
    ports = {source.controller.board.pins[wire].port for wire in wires}
    read_a_tick = FAR_A_TICK if ports & set(FAR_PORTS) else NEAR_A_TICK
    first_ms = round(sensor.first_conversion_s * 1000)
    averaging = int(math.log2(sensor.average)) << AVERAGING_AT
    return (
        Constant(
            f"{prefix}_STEP_C", f"{sensor.step_k!r}f", f"{source.where}: one step of the reading"
        ),
        Constant(
            f"{prefix}_PERIOD_TICKS",
            f"{use.loop.period_ticks}u",
            f"read every {told_period(use.loop)}, in the ticks up to the step's",
        ),
        Constant(
            f"{prefix}_SETTINGS",
            f"0x{settings:02X}u",
            f"{mains.where}: CR0 with a filter of {quantity(sensor.mains_filter_hz, 'Hz')}, and "
            "the test for an open thermocouple in every 16th conversion",
        ),
        Constant(
            f"{prefix}_AVERAGING", f"0x{averaging:02X}u", f"{average.where}: CR1, {sensor.average}"
        ),
        *(() if sensor.selectable else (_type(source, prefix, sensor),)),
        Constant(
            f"{prefix}_READ_A_TICK",
            f"{read_a_tick}u",
            "registers, in less than 100 us; those of the temperature in one tick",
        ),
        Constant(
            f"{prefix}_READ_TICKS",
            f"{math.ceil(REGISTERS / read_a_tick) + 1}u",
            f"to read and check all {REGISTERS} registers, after the tick that selects the chip",
        ),
        Constant(
            f"{prefix}_FIRST_TICKS",
            f"{math.ceil(first_ms / TICK_MS)}u",
            f"the first conversion takes at most {quantity(first_ms, 'ms')}",
        ),
    )


def _type(source: Source, prefix: str, sensor: Max31856) -> Constant:
    """Return the type's code; if types can be chosen, `types_of` returns it instead."""
    return Constant(
        f"{prefix}_TYPE",
        f"{TYPE_CODES.index(sensor.thermocouple)}u",
        f"{source.at('thermocouple').where}: CR1, type {sensor.thermocouple}",
    )


def types_of(root: Source, name: str) -> list[Constant]:
    """Return the codes of the types of thermocouple that a sensor may have."""
    sensor = root.controller.sensors[name]
    assert isinstance(sensor, Max31856)  # noqa: S101 - no other sensor has types
    source = root.at("sensors", name)
    codes = {TYPE_CODES.index(each) for each in (sensor.thermocouple, *sensor.selectable)}
    letters = " ".join(TYPE_CODES[code] for code in sorted(codes))
    return [
        source.at("thermocouple").count(
            f"SENSOR_{name.upper()}_TYPE_GIVEN",
            TYPE_CODES.index(sensor.thermocouple),
            f"{sensor.thermocouple} of {TYPE_CODES}",
        ),
        Constant(
            f"SENSOR_{name.upper()}_TYPES",
            f"0x{sum(1 << code for code in codes):02X}u",
            f"{source.at('selectable').where}: {letters}, a bit for each of {TYPE_CODES}",
        ),
    ]
