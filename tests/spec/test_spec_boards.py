"""The boards' data against avr-libc and Arduino, who wrote it down, too; who gets which timer."""

import re
from functools import cache
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rig.firmware import finished

from heatwright.spec import BOARDS, Board, Controller, Ds18b20, PwmOutput, Stepper, Timer
from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.board import pwm_timers as waves
from heatwright.spec.board.timers import Interval, NoTimer, TimerUse, allocate, tick_interval
from heatwright.spec.board.uart import BAUD_TOLERANCE, baud_setting
from heatwright.spec.boards.build import FINE_PRESCALERS, SLOW_PRESCALERS

VARIANTS = Path("/usr/share/arduino/hardware/arduino/avr/variants")
BY_VARIANT = {"uno": "standard", "mega2560": "mega", "leonardo": "leonardo"}
CHIPS = sorted({board.mcu for board in BOARDS.values()})


@cache
def preprocessed(mcu: str, *words: str) -> str:
    return finished(["avr-gcc", f"-mmcu={mcu}", "-E", "-x", "c", *words], check=True).stdout


@cache
def macros(mcu: str) -> dict[str, str]:
    found = preprocessed(mcu, "-dM", "-include", "avr/io.h", "/dev/null")
    lines = (line.split(maxsplit=2) for line in found.splitlines())
    return {words[1]: words[2] for words in lines if len(words) == 3}


def board_of(mcu: str) -> Board:
    return next(board for board in BOARDS.values() if board.mcu == mcu)


def value(mcu: str, name: str) -> int:
    """Add up a macro such as `(RAMSTART + RAMSIZE - 1)`."""
    total = 0
    for sign, term in re.findall(r"([+-]?)\s*(\w+)", macros(mcu)[name]):
        size = int(term, 0) if term[0].isdigit() else value(mcu, term)
        total += -size if sign == "-" else size
    return total


@pytest.mark.parametrize("mcu", CHIPS)
def test_memories(mcu: str) -> None:
    board = board_of(mcu)
    flash_and_ram = (value(mcu, "FLASHEND") + 1, value(mcu, "RAMSTART"))
    assert (board.flash_bytes, board.ram_start) == flash_and_ram
    assert board.ram_bytes == value(mcu, "RAMEND") + 1 - board.ram_start
    assert board.eeprom_bytes == value(mcu, "E2END") + 1
    assert board.signature == tuple(value(mcu, f"SIGNATURE_{i}") for i in range(3))


@pytest.mark.parametrize("mcu", CHIPS)
def test_timers(mcu: str) -> None:
    known = macros(mcu)
    timers = board_of(mcu).timers
    for number, timer in timers.items():
        assert f"TCNT{number}" in known
        assert (timer.bits == 16) == (f"ICR{number}" in known)
        for channel in timer.channels:
            assert f"OCR{number}{channel}" in known
        # Seven clock-select codes with a prescaler: five of them, and two for an outer clock, on
        # the timers that have one; the bit AS2 tells which does not.
        assert len(timer.prescalers) == (7 if f"AS{number}" in known else 5)
    missing = {0, 1, 2, 3, 4, 5} - set(timers)
    left_out = {4} if mcu == "atmega32u4" else set()
    assert {number for number in missing if f"TCNT{number}" in known} == left_out


@pytest.mark.parametrize("mcu", CHIPS)
def test_ports_compare_outputs_and_serial_ports(mcu: str) -> None:
    known = macros(mcu)
    board = board_of(mcu)
    for pin in board.pins.values():
        if pin.digital:
            assert f"PORT{pin.port}{pin.bit}" in known or f"P{pin.port}{pin.bit}" in known
        if pin.pwm is not None:
            number, channel = pin.pwm
            assert channel in board.timers[number].channels
    suffixes = {uart.suffix for uart in board.uarts}
    assert suffixes == {end for end in ("", "0", "1", "2", "3") if f"UDR{end}" in known}


def array(variant: str, mcu: str, name: str) -> list[str]:
    text = preprocessed(mcu, "-DARDUINO_MAIN", str(VARIANTS / variant / "pins_arduino.h"))
    body = re.search(rf"{name}\[\]\s*=\s*\{{(.*?)\}};", text, re.DOTALL)
    assert body is not None
    plain = re.sub(r"#.*", "", body[1])
    return [word.strip() for word in plain.split(",") if word.strip()]


@pytest.mark.parametrize("name", BY_VARIANT)
def test_printed_names(name: str) -> None:
    board, variant = BOARDS[name], BY_VARIANT[name]
    ports = array(variant, board.mcu, "digital_pin_to_port_PGM")
    bits = array(variant, board.mcu, "digital_pin_to_bit_mask_PGM")
    timers = array(variant, board.mcu, "digital_pin_to_timer_PGM")
    first_analog = {"uno": 14, "mega2560": 54, "leonardo": 18}[name]
    seen = set()
    for number, (port, bit, timer) in enumerate(zip(ports, bits, timers, strict=True)):
        digital, analog = f"D{number}", f"A{number - first_analog}"
        printed = digital if digital in board.pins else analog
        if printed not in board.pins:
            assert (name, number) in {("leonardo", n) for n in range(24, 31)}  # A6 to A11, TX LED
            continue
        seen.add(printed)
        pin = board.pins[printed]
        index = re.search(r"1 << \(?\s*(\d)", bit)
        assert index is not None
        assert (pin.port, pin.bit) == (port.removeprefix("P"), int(index[1]))
        if "4" not in timer or name != "leonardo":
            of_arduino = re.fullmatch(r"TIMER(\d)([ABCD])", timer)
            ours = pin.pwm and f"TIMER{pin.pwm[0]}{pin.pwm[1]}"
            assert ours == (of_arduino[0] if of_arduino else None)
    assert seen == {printed for printed in board.pins if printed[0] in "DA"}


def test_a_nano_is_an_uno_with_two_more_analog_pins() -> None:
    uno, nano = BOARDS["uno"], BOARDS["nano"]
    assert {name: nano.pins[name] for name in uno.pins} == uno.pins
    assert set(nano.pins) - set(uno.pins) == {"A6", "A7"}
    assert not nano.pins["A6"].digital
    assert nano.pins["A7"].adc == 7


@pytest.mark.parametrize("board", BOARDS.values(), ids=BOARDS)
def test_names_and_functions_of_pins(board: Board) -> None:
    for name, pin in board.pins.items():
        assert board.pins[pin.name] is pin
        if pin.digital:
            assert board.pins[pin.port_name] is pin
        assert name in {pin.name, pin.port_name}
    pins = {pin.name: pin for pin in board.pins.values()}.values()
    assert [pin.spi for pin in pins if pin.spi and pin.spi != "ss"].count("sck") == 1
    assert {pin.spi for pin in pins} >= {"sck", "mosi", "miso"}
    channels = [pin.adc for pin in pins if pin.adc is not None]
    assert len(channels) == len(set(channels)) >= 6
    for uart in board.uarts:
        assert (board.pins[uart.rx].serial, board.pins[uart.tx].serial) == ("rx", "tx")
    assert [pin.name for pin in pins if pin.led] == ([] if board.bootloader_bytes == 0 else ["D13"])
    assert any(pin.bootloader for pin in pins) == (board.bootloader_bytes > 0)
    assert board.clock_hz <= board.fastest_hz
    if board.shield:
        assert {f"D{n}" for n in range(14)} | {f"A{n}" for n in range(6)} <= set(board.pins)


def test_channels_of_the_keys() -> None:
    """A0 is another channel on a Leonardo."""
    assert [BOARDS[name].pins["A0"].adc for name in BY_VARIANT] == [0, 0, 7]


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
        is_pwm = frequency[0].isdecimal()
        made[pin if is_pwm else "feed"] = pwm(pin, frequency) if is_pwm else stepper(each)
    return chamber.model_copy(
        update={
            "identity": chamber.identity.model_copy(update={"board": board}),
            "sensors": ReadOnlyDict({f"s{n}": sensor for n in range(sensors)}),
            "outputs": ReadOnlyDict({**chamber.outputs, **made}),
        }
    )


def told(use: TimerUse) -> str:
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
        ("uno", 1, "", "tick: 1, s0: 2"), ("uno", 2, "", "tick: 1, s0: 2, s1: 0"),
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
        # The faster of two frequencies may need the timer.
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
         "no timer drives D4 (PD4); it would be made by interrupts, and no channel"),
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
    st.lists(st.floats(1.0, waves.FASTEST_BY_INTERRUPTS_HZ), min_size=1, max_size=3),
    st.sampled_from([8_000_000, 16_000_000, 20_000_000]),
)
def test_interrupts_keep_every_frequency(wanted_hz: list[float], clock_hz: int) -> None:
    settings = waves.settings_by_interrupts(clock_hz, SIXTEEN, wanted_hz)
    if not settings:
        # Alone each of them could be: it is their distance that is too large.
        bridged = waves.MOST_COUNTS_BY_INTERRUPTS / 8 / waves.FEWEST_COUNTS / 2
        assert max(wanted_hz) / min(wanted_hz) > bridged
        assert all(waves.settings_by_interrupts(clock_hz, SIXTEEN, [each]) for each in wanted_hz)
    assert len({setting.prescaler for setting in settings}) <= 1
    for setting, each_hz in zip(settings, wanted_hz, strict=False):
        assert waves.FEWEST_COUNTS <= setting.counts <= waves.MOST_COUNTS_BY_INTERRUPTS
        assert waves.keeps_frequency(setting, each_hz)
        assert setting.frequency_hz == clock_hz / setting.prescaler / setting.counts


@pytest.mark.parametrize("looks", [0, 10])
@pytest.mark.parametrize("timer", [EIGHT, FINE, SIXTEEN], ids=["eight", "fine", "sixteen"])
@pytest.mark.parametrize("clock_mhz", [*range(8, 21), 14.7456])
def test_every_usual_crystal_ticks_exactly(clock_mhz: float, timer: Timer, looks: int) -> None:
    """By the fewest interrupts, of which every second looks at lines; then by the most counts."""
    cycles = round(clock_mhz * 10_000)
    divider, prescaler = min(
        (divider, prescaler)
        for divider in range(1, 256)
        if not looks or (divider >= 2 * looks and divider % 2 == 0)
        for prescaler in timer.prescalers
        if cycles % (divider * prescaler) == 0 and cycles // divider // prescaler <= 1 << timer.bits
    )
    expected = Interval(prescaler, cycles // divider // prescaler, divider)
    assert tick_interval(100 * cycles, timer, looks) == expected


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
    assert (setting.divisor, setting.baud) == (divisor, clock_hz / 8 / (divisor + 1))
    assert (abs(setting.error) <= BAUD_TOLERANCE) == borne
