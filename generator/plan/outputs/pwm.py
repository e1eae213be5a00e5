"""PWM outputs: by the timer of the pin, or by interrupts of a free-running timer."""

import math
from dataclasses import dataclass

from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.outputs.common import UseOfOutput, output_part
from heatwright.generator.plan.parts import Call, Constant, Part, Stage
from heatwright.generator.plan.pins import label
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.timers import fast_pwm, free_running, registers
from heatwright.spec import Board, Controller, PwmOutput
from heatwright.spec.board.pwm_timers import (
    LATEST_INTERRUPT_S,
    PwmChannel,
    keeps_frequency,
    pwm_setting,
)


@dataclass(frozen=True, slots=True)
class PwmNames:
    """The values for the templates of any PWM."""

    timer: int
    channel: str
    made_by: str
    compare: str


@dataclass(frozen=True, slots=True)
class ByTimer:
    """C statements, and a C type, for an output whose PWM a timer makes."""

    setup: list[str]
    disconnect: str
    connect: str
    compare_type: str
    pulses: str


@dataclass(frozen=True, slots=True)
class ByInterrupts:
    """C names and statements for PWM by interrupts, and the reason for it."""

    setup: list[str]
    reason: str
    counter: str
    vector: str
    interrupt_on: str
    interrupt_off: str
    pulses: str


def plan(source: Source, name: str, output: PwmOutput, use: UseOfOutput) -> Part:
    """Plan a heater, or a fan that the host commands."""
    channel = use.channel
    assert channel is not None  # noqa: S101 - the allocation gave every PWM output one
    board = source.controller.board
    prefix = f"OUTPUT_{name.upper()}"
    constants = _constants(source, output, channel, prefix)
    compare = registers(board, channel.timer).compare(channel.channel)
    made: ByTimer | ByInterrupts
    if channel.by_interrupts:
        template, made = "outputs/pwm_by_interrupts", _by_interrupts(board, output, channel)
        least = math.ceil(board.clock_hz / channel.prescaler * LATEST_INTERRUPT_S)
        constants.append(
            Constant(
                f"{prefix}_MINIMUM_COUNTS",
                f"{least}u",
                f"{LATEST_INTERRUPT_S * 1e6:g} us: the latest interrupt",
            )
        )
        by = f"by interrupts of timer {channel.timer}"
    else:
        template, made = "outputs/pwm", _by_timer(source.controller, output, channel, prefix)
        by = f"by timer {channel.timer}"
    return output_part(
        source,
        name,
        output,
        use,
        template,
        header="outputs/pwm",
        constants=tuple(constants),
        told=(PwmNames(channel.timer, channel.channel, by, compare), made),
        start_calls=(Call(Stage.SENSE, f"output_{name}.h", f"output_{name}_start();"),),
        wired=f", {quantity(channel.frequency_hz, 'Hz')} {by}",
        connected=(made.disconnect,) if isinstance(made, ByTimer) else (),
        pulses=made.pulses,
    )


def _constants(
    source: Source, output: PwmOutput, channel: PwmChannel, prefix: str
) -> list[Constant]:
    shown = ""
    if output.supply_v and output.rated_v and output.full_share < 1:
        shown = f" x ({quantity(output.rated_v, 'V')} / {quantity(output.supply_v, 'V')})^2"
    return [
        source.at("frequency").count(
            f"{prefix}_PERIOD_COUNTS",
            channel.counts,
            f"{quantity(channel.frequency_hz, 'Hz')}, clock / {channel.prescaler}",
        ),
        source.at("supply" if shown else "frequency").number(
            f"{prefix}_COUNTS_PER_PERCENT",
            channel.counts * output.full_share / 100,
            f"{channel.counts}{shown} / 100 %",
        ),
    ]


def _connection(output: PwmOutput, number: int, letter: str) -> str:
    """Bits that connect a pin to its timer; both bits invert it, for a load that is on at low."""
    first = f"(1u << COM{number}{letter}1)"
    return first if output.active == "high" else f"{first} | (1u << COM{number}{letter}0)"


def _connections(controller: Controller, number: int) -> str:
    """The bits that connect all outputs of a timer to their pins."""
    pins = controller.board.pins
    found = [
        _connection(output, number, pwm[1])
        for output in controller.outputs.values()
        if isinstance(output, PwmOutput) and (pwm := pins[output.pin].pwm) and pwm[0] == number
    ]
    return " | ".join(found)


def _by_timer(
    controller: Controller, output: PwmOutput, channel: PwmChannel, prefix: str
) -> ByTimer:
    names = registers(controller.board, channel.timer)
    number, letter = channel.timer, channel.channel
    both = f"(1u << COM{number}{letter}1) | (1u << COM{number}{letter}0)"
    bits = _connection(output, number, letter)
    return ByTimer(
        setup=fast_pwm(
            names,
            channel.prescaler,
            f"{prefix}_PERIOD_COUNTS - 1u",
            _connections(controller, number),
        ),
        disconnect=f"{names.control_a} &= (uint8_t)~({both});",
        connect=f"{names.control_a} |= {bits};",
        compare_type=names.compare_type,
        pulses=f"({names.control_a} & ({both}))",
    )


def _by_interrupts(board: Board, output: PwmOutput, channel: PwmChannel) -> ByInterrupts:
    names, letter = registers(board, channel.timer), channel.channel
    return ByInterrupts(
        setup=free_running(names, channel.prescaler),
        reason=_reason(board, output),
        counter=names.counter,
        vector=names.vector(letter),
        interrupt_on=names.interrupt_on(letter),
        interrupt_off=names.interrupt_off(letter),
        pulses=names.interrupt_is_on(letter),
    )


def _reason(board: Board, output: PwmOutput) -> str:
    pin = board.pins[output.pin]
    wanted = quantity(output.frequency_hz, "Hz")
    if pin.pwm is None:
        return f"No timer drives {label(pin)}"
    if not keeps_frequency(pwm_setting(board, output), output.frequency_hz):
        return f"Timer {pin.pwm[0]}, to which {label(pin)} belongs, cannot make {wanted}"
    return f"Timer {pin.pwm[0]}, to which {label(pin)} belongs, has another output's frequency"
