"""What an output makes of a duty: counts, their course in time, and minimum times."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.outputs.course import course_of
from heatwright.sim.reference.outputs.held import Held
from heatwright.sim.reference.outputs.output import heater_of, pwm_period
from heatwright.spec import DigitalOutput, PwmOutput, TimeProportionalOutput
from heatwright.spec.base import ReadOnlyDict


def pwm(**settings):
    basic = {"kind": "pwm", "pin": "D3", "power": "240 W", "frequency": "490 Hz"}
    return PwmOutput.model_validate(basic | settings)


def windows(**settings):
    return TimeProportionalOutput.model_validate(
        {"kind": "time_proportional", "pin": "D3", "power": "240 W", "window": "1 s", **settings}
    )


def test_one_prescaler_serves_all_outputs_of_a_timer(vary):
    """Only pulses that interrupts make have a least length."""
    assert pwm_period(vary(output=pwm(pin="D9")), "heater") == (32653, 0)
    controller = vary(output=pwm(pin="D3", frequency="122 Hz"))
    assert pwm_period(controller, "heater") == (16393, 100)
    outputs = {**controller.outputs, "second": pwm(pin="D4", frequency="30 Hz")}
    both = controller.model_copy(update={"outputs": ReadOnlyDict(outputs)})
    assert pwm_period(both, "heater") == (2049, 13)
    assert pwm_period(both, "second") == (8333, 13)


COUNTS = {
    "to the nearest": (pwm(), {0.0: 0, 0.19: 0, 0.2: 1, 50: 128, 99.8: 255, 99.81: 256, 100: 256}),
    # Repetier's example: a heater for 12 V run from 18 V, 255 x 12^2 / 18^2 = 113.
    "a higher supply is on for less": (
        pwm(supply="18 V", rated="12 V"),
        {100: round(256 * 144 / 324)},
    ),
    "pulses by interrupts are not shorter than they are late": (
        pwm(pin="D4", frequency="500 Hz"),
        {0: 0, 2.4: 0, 2.496: 0, 2.5: 800, 50: 16000, 97.5: 31200, 97.504: 32000, 97.6: 32000},
    ),
    "short pulses and pauses are left out": (
        windows(minimum_on="50 ms", minimum_off="100 ms"),
        {0: 0, 4.4: 0, 4.5: 5, 5: 5, 50: 50, 90: 90, 90.4: 90, 90.6: 100, 100: 100},
    ),
}


@pytest.mark.parametrize("what", COUNTS)
def test_counts_of_a_duty(vary, what):
    output, wanted = COUNTS[what]
    heater = heater_of(vary(output=output), "heater")
    found = {}
    for duty in wanted:
        heater.apply(Single(duty))
        found[duty] = heater.counts
    assert found == wanted


# ---- minimum times, in ticks and in time ----

ORDERS = st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), max_size=200)
"""Asked, permitted, and stopped, in each tick."""


def course(held: Held, orders: list[tuple[bool, bool, bool]]) -> list[bool]:
    found = []
    for asked, permitted, stopped in orders:
        found.append(held.tick(permitted=permitted))
        held.set(asked=asked)
        if stopped:
            held.stop()
    return found


@given(ORDERS, st.integers(0, 20), st.integers(0, 20))
def test_it_is_never_on_or_off_for_less_than_the_minimum(orders, minimum_on, minimum_off):
    """But for what is not permitted or stopped, which is off at once."""
    on_in_tick = course(Held(minimum_on, minimum_off), orders)
    for on, (_, permitted, _) in zip(on_in_tick, orders, strict=True):
        assert permitted or not on
    pauses = "".join("10"[not on] for on in on_in_tick).split("1")[:-1]
    assert all(len(pause) >= minimum_off for pause in pauses[1:] if pause)
    assert not pauses or len(pauses[0]) >= minimum_off - 1  # the tick that switches is its end
    free = course(Held(minimum_on, minimum_off), [(asked, True, False) for asked, *_ in orders])
    pulses = "".join("10"[not on] for on in free).split("0")[:-1]
    assert all(len(pulse) >= minimum_on for pulse in pulses if pulse)


def test_an_output_with_minimum_times_has_such_a_course(vary):
    told = {"kind": "digital", "pin": "D3", "power": "240 W", "minimum_on": "2 s"}
    run = course_of(vary(output=DigitalOutput.model_validate(told)), "heater")
    run.apply(1)
    run.advance(1_000_000)
    run.apply(0)
    assert run.advance(3_000_000) == pytest.approx(1_010_000)
