"""How long an interrupt may delay others, and how long the tick's interrupt takes."""

from collections.abc import Iterator
from typing import NamedTuple

from heatwright.spec.board.pwm_timers import LATEST_INTERRUPT_S, share_pwm
from heatwright.spec.controller import Controller
from heatwright.spec.outputs import is_held

ANY_S = 100e-6
"""Longest delay of an interrupt if no part needs less: a hundredth of the tick."""
SLOT_S = 50e-6
"""Longest delay within a 1-Wire slot: a slot that writes a 0 lasts 64 µs, and may last 120 µs."""
OTHERS_S = 10e-6
"""Time of the two interrupts that may delay a PWM's: a serial line's and another channel's."""
BITS_OF_A_BYTE = 10
"""Minimum number of bits of a byte on a serial line: a start bit, eight bits, a stop bit."""

# Cycles of the tick's interrupt, each a little more than was measured: their sum is a bound.
TICK_CYCLES = 135
LOOP_CYCLES = 65
WINDOW_CYCLES = 45
"""Cycles for each heater with time-proportional control."""
HELD_CYCLES = 45
"""Cycles for each heater or cooler with minimum times."""
BY_INTERRUPTS_CYCLES = 85
"""Cycles for each heater whose PWM is made by interrupts."""
COOLER_CYCLES = 80
FAN_CYCLES = 30
RELAY_CYCLES = 100
STEPPER_CYCLES = 15
INPUTS_CYCLES = 30
INPUT_CYCLES = 10
"""Cycles for each input of the machine."""


class Wait(NamedTuple):
    """How long a part can wait while interrupts are off, s; its name; what can wait longer."""

    seconds: float
    what: str
    instead: str


def waits(controller: Controller) -> Iterator[Wait]:
    """List the parts that interrupts serve, and how late an interrupt may come without lost data.

    A receiver holds one byte while the next one comes in. A PWM by interrupts omits pulses that are
    shorter than its latest interrupt is late. A stepper's step may be late by half of the interval
    between two steps.
    """
    yield Wait(ANY_S, "a hundredth of the tick", "")
    for name, sensor in controller.sensors.items():
        if sensor.on_one_wire:
            yield Wait(SLOT_S, f"the slots of {name}'s bus", "a sensor of another kind")
    for part in controller.interfaces:
        if part.line is not None and part.line.receives:
            wait_s = BITS_OF_A_BYTE / part.line.baud
            yield Wait(wait_s, f"a byte on the line of {part.kind}", "a slower line")
    for name, channel in share_pwm(controller).channels.items():
        if channel.by_interrupts:
            other = "the kind time_proportional"
            wait_s = LATEST_INTERRUPT_S - OTHERS_S
            yield Wait(wait_s, f"the PWM of {name}, by interrupts", other)
    for name, stepper in controller.steppers.items():
        step_s = 1 / (stepper.maximum_mm_per_s * stepper.steps_per_mm)
        yield Wait(step_s / 2, f"half a step of {name}", "a slower maximum")


def longest_wait_s(controller: Controller) -> float:
    """Return the longest time for which interrupts may be off, s."""
    return min(each.seconds for each in waits(controller))


def longest_tick_s(controller: Controller) -> float:
    """Return how long the tick's interrupt takes at most, s: no other interrupt takes longer."""
    outputs, channels = controller.outputs, share_pwm(controller).channels
    cycles = TICK_CYCLES
    cycles += RELAY_CYCLES * (controller.safety.relay is not None)
    inputs = len(controller.safety.inputs)
    cycles += INPUTS_CYCLES * bool(inputs) + INPUT_CYCLES * inputs
    cycles += STEPPER_CYCLES * len(controller.steppers)
    for loop in controller.loops.values():
        cycles += LOOP_CYCLES + FAN_CYCLES * (loop.fan is not None)
        cycles += COOLER_CYCLES * (loop.cooler is not None)
        cycles += WINDOW_CYCLES * (loop.heater in outputs and outputs[loop.heater].is_windowed)
        for name in filter(None, (loop.heater, loop.cooler)):
            cycles += HELD_CYCLES * (name in outputs and is_held(outputs[name]))
        channel = channels.get(loop.heater)
        cycles += BY_INTERRUPTS_CYCLES * (channel is not None and channel.by_interrupts)
    return cycles / controller.board.clock_hz
