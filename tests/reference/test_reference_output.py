import pytest

from heatwright.sim.reference.course import WindowCourse, course_of
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.output import heater_of, pwm_period
from heatwright.spec import PwmOutput, TimeProportionalOutput
from heatwright.spec.base import ReadOnlyDict


def pwm(**settings):
    return PwmOutput.model_validate({"kind": "pwm", "pin": "D3", "power": "240 W", **settings})


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
        (
            "D3",
            "30 Hz",
            8333,
            13,
        ),  # by interrupts; of clock / 8 they were 66667
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


def test_pulses_by_interrupts_are_not_shorter_than_they_are_late(vary):
    heater = heater_of(vary(output=pwm(pin="D4", frequency="500 Hz")), "heater")
    found = []
    for duty in (0.0, 2.4, 2.496, 2.5, 50.0, 97.5, 97.504, 97.6, 100.0):
        heater.apply(Single(duty))
        found.append(heater.counts)
    assert found == [0, 0, 0, 800, 16000, 31200, 32000, 32000, 32000]


def test_a_higher_supply_is_on_for_less(vary):
    """Repetier's example: a heater for 12 V run from 18 V, 255 x 12^2 / 18^2 = 113."""
    heater = heater_of(vary(output=pwm(frequency="490 Hz", supply="18 V", rated="12 V")), "heater")
    heater.apply(Single(100.0))
    assert heater.counts == round(256 * 144 / 324)


def test_duty_is_rounded_to_the_nearest_count(vary):
    heater = heater_of(vary(output=pwm(frequency="490 Hz")), "heater")
    found = []
    for duty in (0.0, 0.19, 0.2, 50.0, 99.8, 99.81, 100.0):
        heater.apply(Single(duty))
        found.append(heater.counts)
    assert found == [0, 0, 1, 128, 255, 256, 256]


def test_short_pulses_and_pauses_are_left_out(vary):
    output = windows(minimum_on="50 ms", minimum_off="100 ms")
    heater = heater_of(vary(output=output), "heater")
    found = []
    for duty in (0, 4.4, 4.5, 5, 50, 90, 90.4, 90.6, 100):
        heater.apply(Single(duty))
        found.append(heater.counts)
    assert found == [0, 0, 5, 5, 50, 90, 90, 100, 100]


def test_a_window_is_on_first_and_off_then():
    course = WindowCourse(1_000_000, 10_000)
    assert course.advance(500_000) == 0
    course.apply(25)
    assert course.advance(600_000) == 100_000
    assert course.advance(1_000_000) == 150_000
    assert course.advance(1_600_000) == 100_000  # the second window began at 1.5 s
    assert course.advance(3_500_000) == 150_000 + 250_000


def test_a_new_duty_waits_for_its_window_but_zero_does_not():
    course = WindowCourse(10_000_000, 10_000)
    course.apply(500)
    course.advance(1_000_000)
    course.apply(200)
    assert course.advance(6_000_000) == 4_000_000
    assert course.advance(10_000_000) == 0
    assert course.advance(11_000_000) == 1_000_000
    course.apply(0)
    assert course.advance(20_000_000) == 0


def test_a_duty_at_the_start_of_a_window_counts_at_once():
    course = WindowCourse(1_000_000, 10_000)
    course.apply(10)
    assert course.advance(1_000_000) == 100_000
    course.apply(90)
    assert course.advance(2_000_000) == 900_000


def test_a_pwm_course_is_its_mean(vary):
    course = course_of(vary(output=pwm(frequency="490 Hz")), "heater")
    course.apply(64)
    assert course.advance(1_000_000) == pytest.approx(250_000, rel=1e-15)
