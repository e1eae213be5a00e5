import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatwright.spec import Controller, Ds18b20, PwmOutput, Stepper, Timer
from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.boards.build import FINE_PRESCALERS, SLOW_PRESCALERS
from heatwright.spec.pwm import (
    FASTEST_BY_INTERRUPTS_HZ,
    FEWEST_COUNTS,
    MOST_COUNTS_BY_INTERRUPTS,
    keeps_frequency,
    settings_by_interrupts,
)
from heatwright.spec.timers import Interval, NoTimer, TimerUse, allocate, tick_interval
from heatwright.spec.uart import BAUD_TOLERANCE, baud_setting

EIGHT = Timer(8, SLOW_PRESCALERS, ("A", "B"))
FINE = Timer(8, FINE_PRESCALERS, ("A", "B"))
SIXTEEN = Timer(16, SLOW_PRESCALERS, ("A", "B"))


def pwm(pin: str, frequency: str) -> PwmOutput:
    return PwmOutput.model_validate({"kind": "pwm", "pin": pin, "frequency": frequency})


def stepper(maximum: str) -> Stepper:
    pins = {"kind": "stepper", "step": "D4", "direction": "D5", "enable": "D6"}
    motor = {"steps": 200, "microsteps": 16, "lead": "25 mm", "acceleration": "50 mm/s²"}
    return Stepper.model_validate({**pins, **motor, "maximum": maximum})


def asked(chamber: Controller, board: str, sensors: int, outputs: str) -> Controller:
    """The chamber with so many 1-Wire lines, and outputs as `PIN FREQUENCY` or `SPEED`."""
    sensor = Ds18b20(kind="ds18b20", pin="A1")
    made: dict[str, PwmOutput | Stepper] = {}
    for each in outputs.split(", ") if outputs else ():
        pin, _, frequency = each.partition(" ")
        made[pin if frequency[0].isdecimal() else "feed"] = (
            pwm(pin, frequency) if frequency[0].isdecimal() else stepper(each)
        )
    return chamber.model_copy(
        update={
            "identity": chamber.identity.model_copy(update={"board": board}),
            "sensors": ReadOnlyDict({f"s{n}": sensor for n in range(sensors)}),
            "outputs": ReadOnlyDict({**chamber.outputs, **made}),
        }
    )


def told(use: TimerUse) -> str:
    """Who has which timer; of PWM the channel, the prescaler, the counts, and who makes it."""
    channels = {
        name: f"{each.timer}{each.channel} {each.prescaler}*{each.counts}"
        f"{' interrupts' if each.by_interrupts else ''}"
        for name, each in use.pwm.items()
    }
    users = {"tick": use.tick, **use.one_wire, **channels, **use.steppers}
    return ", ".join(f"{name}: {timer}" for name, timer in users.items())


@pytest.mark.parametrize(
    ("board", "sensors", "outputs", "expected"),
    [
        ("uno", 1, "", "tick: 1, s0: 2"),
        ("uno", 2, "", "tick: 1, s0: 2, s1: 0"),
        ("mega2560", 5, "", "tick: 1, s0: 2, s1: 0, s2: 5, s3: 4, s4: 3"),
        # PWM comes first; there are five interrupts a tick on timer 2 as on timer 0, which is last.
        ("uno", 1, "D9 1 kHz", "tick: 2, s0: 0, D9: 1A 1*16000"),
        ("uno", 1, "D3 490 Hz", "tick: 1, s0: 0, D3: 2B 128*256"),
        ("uno", 1, "D3 62.5 kHz", "tick: 1, s0: 0, D3: 2B 1*256"),
        ("uno", 1, "D5 244 Hz", "tick: 1, s0: 2, D5: 0B 256*256"),
        ("uno", 1, "D9 160 kHz", "tick: 2, s0: 0, D9: 1A 1*100"),
        ("uno", 1, "D9 1 Hz", "tick: 2, s0: 0, D9: 1A 256*62500"),
        # RAMPS: 30 Hz for the hotend and 122 Hz for the fan, both pins of timer 2, which makes
        # neither. One prescaler for both: 30 Hz would be 66667 counts of clock/8.
        (
            "mega2560", 1, "D10 30 Hz, D9 122 Hz",
            "tick: 1, s0: 2, D10: 5A 64*8333 interrupts, D9: 5B 64*2049 interrupts",
        ),
        ("uno", 1, "D4 100 Hz", "tick: 2, s0: 0, D4: 1A 8*20000 interrupts"),
        # Of two frequencies on a timer the faster may need it.
        (
            "mega2560", 1, "D10 61 Hz, D9 7812 Hz",
            "tick: 1, s0: 0, D9: 2B 8*256, D10: 5A 64*4098 interrupts",
        ),
        ("mega2560", 1, "D10 61 Hz, D9 61 Hz", "tick: 1, s0: 0, D10: 2A 1024*256, D9: 2B 1024*256"),
        ("uno", 1, "20 mm/s", "tick: 1, s0: 2, feed: 0"),
        ("mega2560", 1, "20 mm/s", "tick: 1, s0: 2, feed: 3"),
        ("uno", 1, "78.125 mm/s", "tick: 1, s0: 2, feed: 0"),
    ],
)  # fmt: skip
def test_who_has_which_timer(
    chamber: Controller, board: str, sensors: int, outputs: str, expected: str
) -> None:
    use = allocate(asked(chamber, board, sensors, outputs))
    assert told(use) == expected
    for channel in use.pwm.values():
        assert channel.frequency_hz == 16e6 / channel.prescaler / channel.counts


@pytest.mark.parametrize(
    ("sensors", "outputs", "path", "reason"),
    [
        (1, "D9 1 kHz, D4 50 Hz", "D4.frequency",
         "no timer reaches D4 (PD4); it would be made by interrupts, and no channel"),
        (1, "D4 40 Hz, D7 50 Hz, D8 60 Hz", "D8.frequency", "no channel of a 16-bit timer of uno"),
        # 1 Hz needs so slow a clock that 500 Hz gets 31 counts of it.
        (1, "D4 1 Hz, D7 500 Hz", "D7.frequency", "no channel of a 16-bit timer of uno is left"),
        (2, "20 mm/s", "feed", "left for this stepper"),
    ],
)  # fmt: skip
def test_what_no_timer_is_left_for(
    chamber: Controller, sensors: int, outputs: str, path: str, reason: str
) -> None:
    with pytest.raises(NoTimer) as caught:
        allocate(asked(chamber, "uno", sensors, outputs))
    (problem,) = caught.value.problems
    assert ".".join(map(str, problem.path)) == f"outputs.{path}"
    assert reason in problem.reason
    assert problem.remedy


@given(
    st.lists(st.floats(1.0, FASTEST_BY_INTERRUPTS_HZ), min_size=1, max_size=3),
    st.sampled_from([8_000_000, 16_000_000, 20_000_000]),
)
def test_interrupts_keep_every_frequency(wanted_hz: list[float], clock_hz: int) -> None:
    settings = settings_by_interrupts(clock_hz, SIXTEEN, wanted_hz)
    if not settings:
        # Alone each of them could be: it is their distance that is too large.
        assert max(wanted_hz) / min(wanted_hz) > MOST_COUNTS_BY_INTERRUPTS / 8 / FEWEST_COUNTS / 2
        assert all(settings_by_interrupts(clock_hz, SIXTEEN, [each]) for each in wanted_hz)
    assert len({setting.prescaler for setting in settings}) <= 1
    for setting, each_hz in zip(settings, wanted_hz, strict=False):
        assert FEWEST_COUNTS <= setting.counts <= MOST_COUNTS_BY_INTERRUPTS
        assert keeps_frequency(setting, each_hz)
        assert setting.frequency_hz == clock_hz / setting.prescaler / setting.counts


@pytest.mark.parametrize("timer", [EIGHT, FINE, SIXTEEN], ids=["eight", "fine", "sixteen"])
@pytest.mark.parametrize("clock_mhz", [*range(8, 21), 14.7456])
def test_every_usual_crystal_ticks_exactly(clock_mhz: float, timer: Timer) -> None:
    """By the fewest interrupts; of those, by the most counts."""
    cycles = round(clock_mhz * 10_000)
    divider, prescaler = min(
        (divider, prescaler)
        for divider in range(1, 256)
        for prescaler in timer.prescalers
        if cycles % (divider * prescaler) == 0 and cycles // divider // prescaler <= 1 << timer.bits
    )
    expected = Interval(prescaler, cycles // divider // prescaler, divider)
    assert tick_interval(100 * cycles, timer) == expected


def test_ticks_of_odd_clocks() -> None:
    assert tick_interval(26_214_400, EIGHT) == Interval(1024, 256, 1)
    assert tick_interval(8_388_608, SIXTEEN) is None


@pytest.mark.parametrize(
    ("clock_hz", "baud", "divisor", "borne"),
    [
        # The data sheet's table of UBRR for U2X = 1, with its errors.
        (16_000_000, 9600, 207, True),  # 0.2 %
        (16_000_000, 57600, 34, True),  # −0.8 %
        (16_000_000, 115200, 16, True),  # 2.1 %
        (16_000_000, 230400, 8, False),  # −3.5 %
        (16_000_000, 250000, 7, True),
        (8_000_000, 115200, 8, False),  # −3.5 %
        (16_000_000, 300, 4095, False),  # beyond twelve bits
    ],
)
def test_baud(clock_hz: int, baud: int, divisor: int, borne: bool) -> None:
    setting = baud_setting(clock_hz, baud)
    assert setting.divisor == divisor
    assert setting.baud == clock_hz / 8 / (divisor + 1)
    assert (abs(setting.error) <= BAUD_TOLERANCE) == borne
