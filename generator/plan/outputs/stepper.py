"""Steppers: drivers with step, direction and enable inputs; each has a timer for its steps."""

import math
from dataclasses import dataclass
from typing import Literal

from heatwright.generator.plan.numbers import TICK_MS, quantity
from heatwright.generator.plan.outputs.common import UseOfOutput, output_names
from heatwright.generator.plan.parts import (
    Call,
    Constant,
    Group,
    Part,
    PinPlan,
    Stage,
    Wiring,
    pair,
    pulled,
)
from heatwright.generator.plan.pins import driven, label, switched
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.timers import TimerRegisters, counting_to_compare, halted, registers
from heatwright.spec import Board, Stepper

PULSE_US = 2
"""High time of STEP: at least 1 us for an A4988 (data sheet, figure 1), 1.9 us for a DRV8825."""

SLOWEST_STEPS_PER_S = 1.0
FINEST_COUNTS_PER_S = 2_500_000
"""Highest count rate: the slowest speed's interval, in 1/256 counts, must fit in 32 bits."""

TICK_S = TICK_MS / 1000


@dataclass(frozen=True, slots=True)
class StepperNames:
    """Further values for the templates."""

    timer: TimerRegisters
    start: list[str]
    stop: list[str]
    pulse_us: int
    ready_loops: list[str]
    ready_where: str


def plan(source: Source, name: str, output: Stepper, use: UseOfOutput) -> Part:
    """Plan a stepper with which the host feeds."""
    assert use.timer is not None  # noqa: S101 - the allocation gave every stepper one
    controller = source.controller
    board, number = controller.board, use.timer
    timer = registers(board, number)
    fastest = output.maximum_mm_per_s * output.steps_per_mm
    prescaler = _prescaler(board, number, fastest)
    ready = [each for each, loop in controller.loops.items() if loop.ready_within_k is not None]
    loops = Source(source.spec, ("loops",))
    stepper = StepperNames(
        timer=timer,
        start=counting_to_compare(timer, prescaler, "set_compare();"),
        stop=halted(timer),
        pulse_us=PULSE_US,
        ready_loops=ready,
        ready_where=", ".join(loops.at(each, "ready_within").where for each in ready),
    )
    file, told = f"output_{name}.h", (output_names(source, name, use), stepper)
    return Part(
        files=pair(f"output_{name}", "outputs/stepper", told),
        groups=(Group(f"Output {name}", _constants(source, output, board, number, prescaler)),),
        pins=_pins(source, name, output, board),
        start_calls=(Call(Stage.SENSE, file, f"output_{name}_start();"),),
        tick_calls=(Call(Stage.STORE, file, f"output_{name}_tick();"),),
        wiring=_wiring(name, output, board),
        reset_lines=(f"pin_output_{name}_enable_off();", f"pin_output_{name}_enable_drive();"),
    )


def _prescaler(board: Board, number: int, fastest_steps_per_s: float) -> int:
    """The finest prescaler for which the fastest interval is one part; otherwise the coarsest."""
    timer = board.timers[number]
    for prescaler in timer.prescalers:
        counts_per_s = board.clock_hz / prescaler
        if counts_per_s <= FINEST_COUNTS_PER_S and (
            counts_per_s / fastest_steps_per_s < (1 << timer.bits) - 1
        ):
            return prescaler
    return timer.prescalers[-1]


def _constants(
    source: Source, output: Stepper, board: Board, number: int, prescaler: int
) -> tuple[Constant, ...]:
    prefix = f"OUTPUT_{source.path[-1]}".upper()
    steps_per_mm = output.steps_per_mm
    per_s2 = output.acceleration_mm_per_s2 * steps_per_mm
    counts_per_s = board.clock_hz / prescaler
    most = (1 << board.timers[number].bits) - 1
    maximum, acceleration = source.at("maximum"), source.at("acceleration")
    shown = f"{quantity(per_s2, 'steps/s^2')}"
    return (
        source.at("steps").number(
            f"{prefix}_STEPS_PER_MM",
            steps_per_mm,
            f"{output.steps} x {output.microsteps} / {quantity(output.lead_mm, 'mm')}",
        ),
        maximum.given(f"{prefix}_MAXIMUM_MM_PER_S", output.maximum_mm_per_s, "mm/s"),
        maximum.number(
            f"{prefix}_FASTEST_STEPS_PER_S",
            output.maximum_mm_per_s * steps_per_mm,
            f"{quantity(output.maximum_mm_per_s, 'mm/s')} x {quantity(steps_per_mm, 'steps/mm')}",
        ),
        Constant(f"{prefix}_SLOWEST_STEPS_PER_S", "1.0f", "the slowest speed"),
        acceleration.number(
            f"{prefix}_STEPS_PER_S_PER_TICK", per_s2 * TICK_S, f"{shown} x {TICK_MS} ms"
        ),
        acceleration.number(
            f"{prefix}_START_STEPS_PER_S",
            max(SLOWEST_STEPS_PER_S, per_s2 * TICK_S, math.sqrt(per_s2)),
            f"{shown}: after half a step from rest, or after a tick; at least the slowest speed",
        ),
        acceleration.number(
            f"{prefix}_PER_TWICE_ACCELERATION", 1 / (2 * per_s2), f"1 / (2 x {shown})"
        ),
        Constant(f"{prefix}_HALF_TICK_S", f"{TICK_S / 2}f", f"half of {TICK_MS} ms"),
        Constant(
            f"{prefix}_COUNTS_256_PER_S",
            f"{256 * counts_per_s:.1f}f",
            f"timer {number}: 256 x clock / {prescaler}",
        ),
        Constant(
            f"{prefix}_MOST_COUNTS_256",
            f"{256 * most}UL",
            f"256 x {most}: a longer interval is divided into parts",
        ),
    )


def _pins(source: Source, name: str, output: Stepper, board: Board) -> tuple[PinPlan, ...]:
    stem = f"output_{name}"
    return (
        driven(source.at("step"), f"{stem}_step", board.pins[output.step], f"steps of {name}"),
        driven(
            source.at("direction"),
            f"{stem}_direction",
            board.pins[output.direction],
            f"direction of {name}, high is forward",
        ),
        switched(
            source.at("enable"),
            f"{stem}_enable",
            board.pins[output.enable],
            output.enable_active,
            f"driver of {name}",
        ),
    )


def _wiring(name: str, output: Stepper, board: Board) -> tuple[Wiring, ...]:
    pull: Literal["up", "down"] = "down" if output.enable_active == "high" else "up"
    rows = (
        ("step", output.step, f"driver's STEP; a step at each rising edge, {PULSE_US} us high"),
        ("direction", output.direction, "driver's DIR; high is forward"),
        (
            "enable",
            output.enable,
            f"driver's ENABLE, active {output.enable_active}; "
            f"10 kΩ pull it {pull} while the chip is in reset",
        ),
    )
    return tuple(
        Wiring(
            label(board.pins[pin]),
            f"output `{name}`: stepper, {what}",
            how,
            (pulled(pull),) if what == "enable" else (),
        )
        for what, pin, how in rows
    )
