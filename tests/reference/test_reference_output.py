"""What an output makes of a duty: counts, and their course in time."""

import pytest

from heatwright.sim.reference.course import WindowCourse, course_of
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.output import heater_of, pwm_period
from heatwright.spec import PwmOutput, TimeProportionalOutput
from heatwright.spec.base import ReadOnlyDict


def pwm(**settings):
    basic = {"kind": "pwm", "pin": "D3", "power": "240 W", "frequency": "490 Hz"}
    return PwmOutput.model_validate(basic | settings)


def windows(**settings):
    return TimeProportionalOutput.model_validate(
        {"kind": "time_proportional", "pin": "D3", "power": "240 W", "window": "1 s", **settings}
    )


@pytest.mark.parametrize(
    ("pin", "frequency", "counts", "fewest"),
    [
        ("D3", "490 Hz", 256, 0),  # timer 2, channel B
        ("D11", "490 Hz", 256, 0),  # timer 2, channel A
        ("D9", "490 Hz", 32653, 0),  # timer 1, 16 bits: 16 MHz / 490 Hz
        ("D9", "30 Hz", 8333, 0),
        ("D9", "25 kHz", 640, 0),
        ("D3", "30 Hz", 8333, 13),  # by interrupts; of clock / 8 they were 66667
        ("D4", "490 Hz", 32653, 800),
        ("D4", "500 Hz", 32000, 800),
    ],
)
def test_pwm_periods(vary, pin, frequency, counts, fewest):
    controller = vary(output=pwm(pin=pin, frequency=frequency))
    assert pwm_period(controller, "heater") == (counts, fewest)


def test_one_prescaler_serves_all_outputs_of_a_timer(vary):
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


WINDOWS = {
    # Of a window's length: the counts that are given, if any, and until when it is on for how long.
    "on first and off then; the second begins at 1.5 s": (
        1_000_000,
        [(None, 500_000, 0), (25, 600_000, 100_000), (None, 1_000_000, 150_000),
         (None, 1_600_000, 100_000), (None, 3_500_000, 150_000 + 250_000)],
    ),
    "a new duty waits for its window but zero does not": (
        10_000_000,
        [(500, 1_000_000, 1_000_000), (200, 6_000_000, 4_000_000), (None, 10_000_000, 0),
         (None, 11_000_000, 1_000_000), (0, 20_000_000, 0)],
    ),
    "a duty at the start of a window counts at once": (
        1_000_000, [(10, 1_000_000, 100_000), (90, 2_000_000, 900_000)]
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", WINDOWS)
def test_windows(what):
    window_us, deeds = WINDOWS[what]
    course = WindowCourse(window_us, 10_000)
    for counts, until_us, on_us in deeds:
        if counts is not None:
            course.apply(counts)
        assert course.advance(until_us) == on_us


def test_a_pwm_course_is_its_mean(vary):
    course = course_of(vary(output=pwm()), "heater")
    course.apply(64)
    assert course.advance(1_000_000) == pytest.approx(250_000, rel=1e-15)
