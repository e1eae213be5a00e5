"""MAX31865: what the firmware needs to know of it."""

from __future__ import annotations

import math

from heatwright.generator.plan.converter import shifted
from heatwright.generator.plan.numbers import TICK_MS, quantity, told_period
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Stage, Wiring, pulled
from heatwright.generator.plan.pins import FAR_PORTS, driven, label, lifted
from heatwright.generator.plan.sensors.common import UseOfSensor
from heatwright.generator.plan.source import Source
from heatwright_max31865.model import CODES, READ_TICKS, Max31865

BIAS, THREE_WIRES, FIFTY_HZ = 0x80, 0x10, 0x01
"""Bits of the configuration."""
REGISTERS, NEAR_A_TICK, FAR_A_TICK = 8, 4, 3
"""Registers, and how many of them are read in a tick; both reach beyond the temperature's."""
LOW_RATIO, HIGH_RATIO = 0.185201, 3.90481
"""Resistance at -200 °C and at 850 °C to that at 0 °C (IEC 60751): beyond is no temperature."""
SHIFT = " through a level shifter to 3.3 V"


def plan(source: Source, name: str, sensor: Max31865, use: UseOfSensor) -> Part:
    """Plan the sensor and the wires to its registers."""
    pins = source.controller.board.pins
    names = sensor.chip_select, sensor.clock, sensor.data_in, sensor.data_out
    select, clock, data_in, data = (pins[each] for each in names)
    context = {
        "name": name,
        "NAME": name.upper(),
        "select": label(select),
        "clock": label(clock),
        "data_in": label(data_in),
        "data": label(data),
        "where": source.where,
    }
    what, of_sensor = f"sensor `{name}`: MAX31865", f"of sensor {name}"
    return Part(
        files=(
            File(f"src/spi_{name}.h", "peripherals/spi_registers.h.j2", context),
            File(f"src/spi_{name}.c", "peripherals/spi_registers.c.j2", context),
            File(f"src/sensor_{name}.h", "heatwright_max31865:max31865.h.j2", context),
            File(f"src/sensor_{name}.c", "heatwright_max31865:max31865.c.j2", context),
        ),
        groups=(Group(f"Sensor {name}", _constants(source, name, sensor, use)),),
        pins=(
            driven(source.at("chip_select"), f"sensor_{name}_select", select, f"CS {of_sensor}"),
            driven(source.at("clock"), f"sensor_{name}_clock", clock, f"SCLK {of_sensor}"),
            driven(source.at("data_in"), f"sensor_{name}_data_in", data_in, f"SDI {of_sensor}"),
            lifted(source.at("data_out"), f"sensor_{name}_data", data, f"SDO {of_sensor}"),
        ),
        start_calls=(Call(Stage.SENSE, f"spi_{name}.h", f"spi_{name}_start();"),),
        tick_calls=(Call(Stage.SENSE, f"sensor_{name}.h", f"sensor_{name}_tick();"),),
        wiring=(
            Wiring(
                label(select),
                what,
                f"CS{SHIFT}; 10 kΩ to its supply",
                (*shifted(SHIFT), pulled("up", rail="3.3 V")),
                "CS",
            ),
            Wiring(label(clock), what, f"SCLK{SHIFT}", shifted(SHIFT), "SCLK"),
            Wiring(label(data_in), what, f"SDI{SHIFT}", shifted(SHIFT), "SDI"),
            Wiring(label(data), what, "SDO; nothing else may drive or pull this line", end="SDO"),
            Wiring("–", what, f"3.3 V, with 100 nF; the {sensor.element} on {sensor.wires} wires"),
            Wiring(
                "–", what, f"reference of {quantity(sensor.reference_ohm, 'Ω')}, 0.1 % or better"
            ),
        ),
    )


def _constants(
    source: Source, name: str, sensor: Max31865, use: UseOfSensor
) -> tuple[Constant, ...]:
    prefix = f"SENSOR_{name.upper()}"
    settings = BIAS | (THREE_WIRES if sensor.wires == 3 else 0)
    settings |= FIFTY_HZ if sensor.mains_filter_hz == 50.0 else 0
    per_code = sensor.reference_ohm / sensor.ohm_at_0 / CODES
    low, high = math.ceil(LOW_RATIO / per_code), math.floor(HIGH_RATIO / per_code)
    ports = {
        source.controller.board.pins[wire].port
        for wire in (sensor.chip_select, sensor.clock, sensor.data_in, sensor.data_out)
    }
    a_tick = FAR_A_TICK if ports & set(FAR_PORTS) else NEAR_A_TICK
    read_ticks = math.ceil(REGISTERS / a_tick) + 1
    assert read_ticks <= READ_TICKS  # noqa: S101 - the model has counted on it
    first_ms = round(sensor.first_conversion_s * 1000)
    reference = source.at("reference").where
    return (
        Constant(
            f"{prefix}_RATIO_PER_CODE",
            f"{per_code!r}f",
            f"{reference}: {quantity(sensor.reference_ohm, 'Ω')} in {CODES} steps, in parts of "
            f"the element's {quantity(sensor.ohm_at_0, 'Ω')} at 0 °C",
        ),
        Constant(f"{prefix}_LOWEST_CODE", f"{low}", "the element at -200 °C"),
        Constant(f"{prefix}_HIGHEST_CODE", f"{high}", "the element at 850 °C"),
        Constant(f"{prefix}_SHORT_CODE", f"{low // 2}u", "halfway to 0: the element is shorted"),
        Constant(
            f"{prefix}_OPEN_CODE",
            f"{(high + CODES - 1) // 2}u",
            "halfway to the largest code: the element is open",
        ),
        Constant(
            f"{prefix}_SETTINGS",
            f"0x{settings:02X}u",
            f"{source.where}: bias, {sensor.wires} wires, a filter of "
            f"{quantity(sensor.mains_filter_hz, 'Hz')}",
        ),
        Constant(
            f"{prefix}_PERIOD_TICKS",
            f"{use.loop.period_ticks}u",
            f"it is read once every {told_period(use.loop)}, in the ticks up to the step's",
        ),
        Constant(f"{prefix}_READ_A_TICK", f"{a_tick}u", "registers, in less than 100 us"),
        Constant(
            f"{prefix}_READ_TICKS",
            f"{read_ticks}u",
            f"to read all {REGISTERS} registers and judge, after the tick in which it is selected",
        ),
        Constant(
            f"{prefix}_FIRST_TICKS",
            f"{math.ceil(first_ms / TICK_MS)}u",
            f"its first conversion takes {quantity(first_ms, 'ms')} at most",
        ),
    )
