"""The ADC's scan in the binary: channels, times, bad codes; and the whole chain from the tip on."""

from collections.abc import Iterable

import numpy as np
import pytest
from rig.firmware import changed, device_of, spec_of, whole
from rig.sensors import KEYS, TWO, AnalogSensor, bed, powered, sensor

from heatwright.sim.binary.elf import ElfError
from heatwright.sim.chain import chain_errors, convert, table_of
from heatwright.sim.circuits import shares
from heatwright.sim.device import AvrDevice
from heatwright.sim.reference.sensors.adc import IdealSensor, converter
from heatwright.spec import BOARDS
from heatwright.spec.sensing.conversion import limits

CELSIUS = "temperature_c"
TICK_S = 0.010
OPEN, SHORT, RANGE, STALE = 17, 2, 18, 4
OVERSAMPLE = 4
ADC_WRONG = 40
ADCSRB = 0x7B
DONE = 1 << 6 | 1 << 4
"""Of ADCSRA, what tells that a conversion is going on, and that one has ended."""
ON_ITSELF = 0x0E
"""ADMUX of the band gap on the ATmega328P, whose internal reference it is: its code is 1023."""
FASTEST_ADC_HZ = 200_000
LONGEST_MASKED_S = 20e-6


@pytest.fixture
def plate() -> AvrDevice:
    return powered(bed("hotend"))


@pytest.fixture
def keyed() -> AvrDevice:
    """The same with the display's keys, which are on another channel."""
    return powered(bed("hotend", interface=KEYS))


def hold(device: AvrDevice, code: int) -> None:
    device.avr.adc.set(1, (code + 0.5) * 5000 / 1024)


def test_its_clock_gives_all_ten_bits_of_the_supply_and_no_input_is_digital(plate):
    plate.advance(0.1)
    assert (plate.read("ADMUX"), plate.read("DIDR0")) == (1 << 6 | 1, 1 << 1)
    prescaler = 1 << (plate.read("ADCSRA") & 7)
    assert FASTEST_ADC_HZ / 2 < plate.avr.clock_hz / prescaler <= FASTEST_ADC_HZ


def test_its_interrupt_is_short(keyed: AvrDevice) -> None:
    profile = keyed.avr.profile(keyed.elf)
    keyed.advance(2.0)
    interrupt = profile.functions["__vector_21"]
    assert interrupt.calls == 2 * 200
    assert interrupt.longest / keyed.avr.clock_hz < LONGEST_MASKED_S


def test_it_is_of_the_last_codes_before_the_step(plate: AvrDevice) -> None:
    """One code may be missed, so they are those of the last five ticks but the last one."""
    hold(plate, 700)
    plate.advance(2.05)
    step_s = float(plate.steps("bed")["time_s"][-1]) + 0.2
    for late in range(1, 8):
        plate.advance(step_s - (late - 0.5) * TICK_S)
        hold(plate, 700 + 1)
        plate.advance(step_s + TICK_S / 2)
        took = int(plate.steps("bed")["reading_raw"][-1]) - OVERSAMPLE * 700
        # Begun after `late` - 1 ticks before the step: the last looks at what began a tick before.
        assert took == min(max(late - 2, 0), OVERSAMPLE), late
        hold(plate, 700)
        plate.advance(step_s + 0.25)
        step_s = float(plate.steps("bed")["time_s"][-1]) + 0.2


def test_every_code_and_what_it_means(plate: AvrDevice) -> None:
    every_code(plate, range(1024))


def every_code(plate: AvrDevice, codes: Iterable[int]) -> None:
    """Each for as long as a step: status, raw number and temperature to the last bit."""
    part = sensor("hotend")
    bounds, convert = limits(part, "atmega328p"), converter(part, BOARDS["uno"])
    codes = np.array(codes)
    for step, code in enumerate(codes):
        hold(plate, int(code))
        plate.advance(0.2 * (step + 1) + 0.1)
    log, codes = plate.steps("bed")[-len(codes) + 1 :], codes[1:]
    outside = codes < bounds.far_low, codes < bounds.low, codes > bounds.far_high
    expected = np.select([*outside, codes > bounds.high], [SHORT, RANGE, OPEN, RANGE], 0)
    np.testing.assert_array_equal(log["reading_status"], expected)
    valid = expected == 0
    np.testing.assert_array_equal(log["reading_raw"][valid], OVERSAMPLE * codes[valid])
    meant = np.array([convert(OVERSAMPLE * int(code)) for code in codes[valid]], np.float32)
    np.testing.assert_array_equal(log["temperature_c"][valid].view("u4"), meant.view("u4"))


@pytest.mark.parametrize(("code", "status"), [(0, SHORT), (15, RANGE), (1015, RANGE), (1023, OPEN)])
def test_one_bad_code_spoils_the_reading(plate: AvrDevice, code: int, status: int) -> None:
    hold(plate, 700)
    plate.advance(2.05)
    step_s = float(plate.steps("bed")["time_s"][-1]) + 0.2
    plate.advance(step_s - 3.5 * TICK_S)
    hold(plate, code)
    plate.advance(step_s - 2.5 * TICK_S)
    hold(plate, 700)
    plate.advance(step_s + 0.3)
    *_, spoiled, sound = plate.steps("bed")
    assert (spoiled["reading_status"], sound["reading_status"]) == (status, 0)
    assert spoiled["reading_raw"] == sound["reading_raw"] == OVERSAMPLE * 700
    assert spoiled["duty_percent"] == 0


def test_a_scan_that_does_not_end_leaves_no_old_reading(plate: AvrDevice) -> None:
    plate.advance(1.0)
    plate.avr.adc.fail(hung=True)
    plate.advance(1.5)
    assert set(plate.steps("bed")["reading_status"][-2:]) == {STALE}
    plate.avr.adc.fail()
    hold(plate, 650)
    plate.advance(2.0)
    last = plate.steps("bed")[-1]
    assert (last["reading_status"], last["reading_raw"]) == (0, OVERSAMPLE * 650)


def test_one_scan_may_be_lost(plate: AvrDevice) -> None:
    """There is a tick to spare in each period."""
    plate.advance(1.05)
    for _ in range(5):
        step_s = float(plate.steps("bed")["time_s"][-1]) + 0.2
        plate.advance(step_s - 2.5 * TICK_S)
        plate.avr.adc.fail(hung=True)
        plate.advance(step_s - 1.5 * TICK_S)
        plate.avr.adc.fail()
        plate.advance(step_s + 0.1)
    assert not plate.steps("bed")["reading_status"].any()


def test_keys_are_heard_beside_a_sensor(keyed: AvrDevice) -> None:
    keyed.advance(1.0)
    for press in range(3):
        keyed.press("up")
        keyed.advance(1.2 + 0.4 * press)
        keyed.press(None)
        keyed.advance(1.4 + 0.4 * press)
    assert keyed.read("settings.bed_setpoint_c") == 60.0  # the first press switches on
    assert not keyed.steps("bed")["reading_status"].any()


def test_channels_from_eight_up_beside_lower_ones() -> None:
    two = powered(TWO)
    two.sense("bed", 60.0)
    two.sense("far", 40.0)
    two.advance(1.0)
    for loop, tip_c in (("bed", 60.0), ("far", 40.0)):
        last = two.steps(loop)[-1]
        assert last["reading_status"] == 0
        assert last["temperature_c"] == pytest.approx(tip_c, abs=0.2)


BOARD_CASES = pytest.mark.parametrize(
    ("board", "pin", "heater"),
    [("nano", "A6", "D3"), ("leonardo", "D4", "D3"), ("mega2560", "A15", "D3"),
     ("atmega1284p", "PA3", "PB3"), ("uno", "A1", "D3")],
)  # fmt: skip
REFERENCE_CASES = pytest.mark.parametrize("circuit", ["hotend", "lm35", "tmp36", "frost"])


@BOARD_CASES
@REFERENCE_CASES
def test_boards_their_channels_and_references(
    board: str, pin: str, heater: str, circuit: str
) -> None:
    """ADC7 without a digital pin, ADC8 and ADC15 through MUX5; AVCC, AREF, 1.1 V and 2.56 V."""
    text = bed(circuit, board=board)
    text = text.replace("pin: A1", f"pin: {pin}").replace("pin: D3", f"pin: {heater}")
    text = text.replace("frequency: 490 Hz", "frequency: 977 Hz")
    device, controller = powered(text), spec_of(text).controller
    device.sense("bed", 60.0)
    device.advance(1.0)
    last = device.steps("bed")[-1]
    both = shares(controller.sensors["bed"], controller.board, [60.0, last[CELSIUS]])
    assert last["reading_status"] == 0
    assert abs(both[0] - both[1]) * 1024 <= 1.0
    for bit in range(8):
        if device.avr.part.adc_mux5 >> bit & 1:
            device.avr.flip(ADCSRB, bit)
    device.advance(2.0)
    assert device.steps("bed")[-1][CELSIUS] == last[CELSIUS]


@BOARD_CASES
@REFERENCE_CASES
@pytest.mark.parametrize("number", [0, 1])
def test_a_known_voltage_is_measured_beside_the_sensors(
    board: str, pin: str, heater: str, circuit: str, number: int
) -> None:
    text = bed(circuit, board=board).replace("self_checks: false", "self_checks: true")
    text = text.replace("pin: A1", f"pin: {pin}").replace("pin: D3", f"pin: {heater}")
    device = powered(text.replace("frequency: 490 Hz", "frequency: 977 Hz"))
    device.sense("bed", 60.0)
    part, internal = device.avr.part, "internal" in text
    above = 0 if internal and part.adc_known == ON_ITSELF else ADC_WRONG
    tried = [(0.92, 0), (1.08, 0), (1.4, above)] if number else [(0.7, ADC_WRONG)]
    for times, code in tried:
        device.avr.adc.known(part.adc_known, times * part.known_mv)
        device.advance(device.time_s + 1.5)
        assert device.read("fault.code") == code


@pytest.mark.parametrize("board", ["uno", "mega2560", "leonardo"])
def test_no_bit_of_its_registers_stays_flipped_where_only_keys_are_on_it(board: str) -> None:
    """Else another channel is looked at until the next reset, and no key can be pressed."""
    text = changed("chamber", ("board: uno", f"board: {board}"))
    device = device_of(text, 19.0)
    device.advance(0.5)
    kept = {"ADMUX": 0xFF, "ADCSRA": 0xFF & ~DONE, "ADCSRB": device.avr.part.adc_mux5}
    before = {name: device.read(name) & bits for name, bits in kept.items()}
    for name, bits in kept.items():
        for bit in range(8):
            device.avr.flip(device.variables[name].address, bit)
            device.advance(device.time_s + 2 * TICK_S)
            assert device.read(name) & bits == before[name], (name, bit)
    device.press("up")
    device.advance(device.time_s + 0.1)
    assert device.read("settings.air_setpoint_c") == 30.0


# From the tip's temperature to what the loop takes it for.

ON_THE_BED = ("hotend", "single", "points", "steinhart", "frost", "lm35", "tmp36", "falling")


@pytest.mark.parametrize("name", ON_THE_BED)
def test_it_is_exact_to_one_step_and_the_references_own(name: str) -> None:
    spec, program = spec_of(bed(name)), whole(bed(name))
    (found,) = chain_errors(spec.controller, program)
    assert found.passed
    assert found.table_steps < 0.5
    assert found.table_steps <= found.chain_steps <= 1.0
    assert len(found.rows) == 7
    assert found.chain_error >= max(row.error for row in found.rows) > 0
    part, board = spec.controller.sensors["bed"], spec.controller.board
    assert isinstance(part, AnalogSensor)
    law, ideal = converter(part, board), IdealSensor(part, board)
    sums = [ideal.read(float(celsius))[1] for celsius in np.linspace(*part.range_c, 500)]
    expected = np.array([law(raw) for raw in sums], np.float32)
    made = convert(table_of(program, "bed"), np.array(sums))
    np.testing.assert_array_equal(made.view("u4"), expected.view("u4"))


def test_a_table_that_is_off_is_found() -> None:
    spec, program = spec_of(bed("hotend")), whole(bed("hotend"))
    at = program.symbols["sensor_bed_points"] + 10 * 8 + 2
    worse = np.frombuffer(program.flash[at : at + 4], "<f4") + np.float32(1.0)
    program.flash = program.flash[:at] + worse.tobytes() + program.flash[at + 4 :]
    (found,) = chain_errors(spec.controller, program)
    assert found.table_steps > 0.5
    assert not found.passed


def test_a_binary_without_a_table_is_refused() -> None:
    with pytest.raises(ElfError, match="sensor_bed_points"):
        table_of(whole("chamber"), "bed")
