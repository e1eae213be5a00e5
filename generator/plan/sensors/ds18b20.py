"""DS18B20 on a 1-Wire line of its own."""

import math
from dataclasses import dataclass

from heatwright.generator.plan.numbers import TICK_MS, quantity
from heatwright.generator.plan.parts import Call, Constant, Group, Part, Stage, Wiring, pair, pulled
from heatwright.generator.plan.pins import label, open_drain
from heatwright.generator.plan.sensors.common import UseOfSensor, raw_type
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.timers import compare_match, halted, registers, slot_interval
from heatwright.spec import Ds18b20, Loop

SLOT_US = 64
"""A slot lasts at least 60 us (data sheet, t_SLOT); the rest is recovery and interrupt latency."""

PRESENCE_US = 61
"""From the end of the reset pulse to reading the answer, without the interrupt's latency: the chip
pulls low at most 60 us after that end, and releases the line at least 75 us after it."""

TRANSFER_TICKS = 5
"""Ticks of a period besides the conversion: set-up, command, its end, reading, checking."""


@dataclass(frozen=True, slots=True)
class OneWireNames:
    """The values for the templates of the sensor and of its line, in addition to its name."""

    pin: str
    step: str
    raw: str
    timer: int
    slot_us: str
    reset_us: str
    vector: str
    counter: str
    start: list[str]
    shared: bool
    stop: list[str]


def plan(source: Source, name: str, sensor: Ds18b20, use: UseOfSensor) -> Part:
    """Plan the sensor, on a timer of its own."""
    timer = use.timer
    assert timer is not None  # noqa: S101 - the spec gives each 1-Wire line one
    board = source.controller.board
    pin = board.pins[sensor.pin]
    interval = slot_interval(board.clock_hz, board.timers[timer], SLOT_US)
    counts_per_us = board.clock_hz / interval.prescaler / 1e6
    slot_us = interval.counts / counts_per_us
    names = registers(board, timer)
    prefix, bus = f"SENSOR_{name.upper()}", f"ONE_WIRE_{name.upper()}"
    line = OneWireNames(
        pin=label(pin),
        step=quantity(1 / 16, "K"),
        raw=raw_type(sensor),
        timer=timer,
        slot_us=f"{slot_us:g}",
        reset_us=f"{8 * slot_us:g}",
        vector=names.vector(),
        counter=names.counter,
        start=compare_match(names, interval, f"{bus}_COMPARE"),
        shared=names.shared,
        stop=halted(names),
    )
    told = source.named(name), line
    bus_constants = (
        Constant(
            f"{bus}_COMPARE",
            f"{interval.counts - 1}u",
            f"timer {timer}: {interval.counts} x {1 / counts_per_us:g} us, {slot_us:g} us per slot",
        ),
        Constant(
            f"{bus}_PRESENCE_COUNT",
            f"{interval.counts - math.ceil(PRESENCE_US * counts_per_us)}u",
            f"the answer is read {PRESENCE_US} us after the reset pulse",
        ),
    )
    return Part(
        files=(
            *pair(f"one_wire_{name}", "peripherals/one_wire", told),
            *pair(f"sensor_{name}", "sensors/ds18b20", told),
        ),
        groups=(
            Group(
                f"Sensor {name}", (*_constants(source, sensor, prefix, use.loop), *bus_constants)
            ),
        ),
        pins=(
            open_drain(source.at("pin"), f"sensor_{name}", pin, f"1-Wire line of sensor {name}"),
        ),
        tick_calls=(Call(Stage.SENSE, f"sensor_{name}.h", f"sensor_{name}_tick();"),),
        wiring=(
            Wiring(
                label(pin),
                f"sensor `{name}`: ds18b20",
                "data line with a 4.7 kΩ pull-up to 5 V; its own 5 V and ground wires",
                (pulled("up", "4.7 kΩ"),),
                "DQ",
            ),
        ),
    )


def _constants(source: Source, sensor: Ds18b20, prefix: str, loop: Loop) -> tuple[Constant, ...]:
    resolution = source.at("resolution")
    bits = sensor.resolution_bits
    conversion = math.ceil(round(sensor.conversion_s * 1e6) / (TICK_MS * 1000))
    start = max(0, loop.period_ticks - conversion - TRANSFER_TICKS)
    return (
        Constant(f"{prefix}_STEP_C", "0.0625f", "one step of the reading, at any resolution"),
        Constant(
            f"{prefix}_RAW_MASK",
            f"0x{0xFFFF & -(1 << (12 - bits)):04X}u",
            f"{resolution.where}: {bits} bit, lower bits are undefined",
        ),
        Constant(
            f"{prefix}_SETTINGS",
            f"0x{((bits - 9) << 5) | 0x1F:02X}u",
            f"{resolution.where}: configuration register for {bits} bit",
        ),
        resolution.count(
            f"{prefix}_CONVERSION_TICKS",
            conversion,
            f"at most {quantity(sensor.conversion_s * 1000, 'ms')} at {bits} bit",
        ),
        Constant(
            f"{prefix}_START_TICKS", f"{start}u", "wait, so that the reading is new at the step"
        ),
    )
