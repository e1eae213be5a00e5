"""PWM outputs: fast PWM of the timer that the pin belongs to."""

from __future__ import annotations

from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.outputs.common import UseOfOutput, heater_part
from heatwright.generator.plan.parts import Call, Part, Stage
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.timers import prescaler_bits
from heatwright.spec import PwmOutput
from heatwright.spec.pwm import pwm_setting


def plan(source: Source, name: str, output: PwmOutput, use: UseOfOutput) -> Part:
    """Plan a heater on a timer's compare output."""
    del use
    board = source.controller.board
    pin = board.pins[output.pin]
    assert pin.pwm is not None  # noqa: S101 - the spec refuses a pin without
    number, channel = pin.pwm
    timer = board.timers[number]
    setting = pwm_setting(board, output)
    prefix = f"OUTPUT_{name.upper()}"
    clock = prescaler_bits(number, timer, setting.prescaler)
    if timer.bits == 16:
        setup = [
            f"ICR{number} = {prefix}_PERIOD_COUNTS - 1u;",
            f"TCCR{number}A = (1u << WGM{number}1);",
            f"TCCR{number}B = (1u << WGM{number}3) | (1u << WGM{number}2) | {clock};",
        ]
    else:
        setup = [
            f"TCCR{number}A = (1u << WGM{number}1) | (1u << WGM{number}0);",
            f"TCCR{number}B = {clock};",
        ]
    both = f"(1u << COM{number}{channel}1) | (1u << COM{number}{channel}0)"
    # Inverted output (both bits) keeps an active-low load conducting for `on_counts`.
    bits = f"(1u << COM{number}{channel}1)" if output.active == "high" else both
    where = source.at("frequency")
    constants = (
        where.count(
            f"{prefix}_PERIOD_COUNTS", setting.counts, quantity(setting.frequency_hz, "Hz")
        ),
        where.number(
            f"{prefix}_COUNTS_PER_PERCENT", setting.counts / 100, f"{setting.counts} / 100 %"
        ),
    )
    return heater_part(
        source,
        name,
        output,
        "outputs/pwm",
        constants=constants,
        context={
            "timer": number,
            "channel": channel,
            "setup": setup,
            "disconnect": f"TCCR{number}A &= (uint8_t)~({both});",
            "connect": f"TCCR{number}A |= {bits};",
            "compare": f"OCR{number}{channel}",
            "compare_type": "uint16_t" if timer.bits == 16 else "uint8_t",
        },
        start_calls=(Call(Stage.SENSE, f"output_{name}.h", f"output_{name}_start();"),),
    )
