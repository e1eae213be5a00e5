"""The firmware's reader on several boards and crystals, and what it makes of any answer. Status and
raw reading of each step; what is not valid leaves the reading as it was. And two baths with a
DS18B20 each, and 85 °C: what also a chip says that has not measured yet."""

from collections.abc import Callable, Iterable
from random import Random
from typing import Any

import numpy as np
import pytest
from rig.firmware import device_of, files_of
from rig.sensors import KINDS, PINS, Crucible, crucible

from heatwright.sim.device import AvrDevice

VALID, NO_ANSWER, SHORT, CRC, STALE, RESET, OPEN, RANGE = 0, 1, 2, 3, 4, 5, 17, 18
STEPS_PER_K = {"max6675": 4, "max31855": 4, "max31856": 128}
ENDS_C = {"max6675": (0.25, 1023.75), "max31855": (-270.0, 1372.0), "max31856": (-199.9, 1371.9)}
Judged = Callable[[int], tuple[int, int]]


def reading_problem(bench: Crucible, count: int) -> str:
    """Take temperatures over the range: each is the nearest code, in the next step but one."""
    kind = bench.controller.sensors["tip"].kind
    bench.steps()
    for celsius in np.linspace(*ENDS_C[kind], count):
        bench.sense(float(celsius))
        step = bench.steps(2)[-1]
        due = np.floor(STEPS_PER_K[kind] * celsius + 0.5)
        if step["reading_status"] != VALID or step["reading_raw"] != due:
            return f"{celsius} °C are {step['reading_raw']}, status {step['reading_status']}"
        if step["temperature_c"] != np.float32(due / STEPS_PER_K[kind]):
            return f"{due} steps are {step['temperature_c']} °C"
    return ""


def judged_6675(word: int) -> tuple[int, int]:
    body = word >> 1
    if body in {0, 0x7FFF}:
        return NO_ANSWER, 0
    if word >> 15 or word >> 1 & 1:
        return CRC, 0
    return (OPEN, 0) if word >> 2 & 1 else (VALID, word >> 3)


def judged_31855(word: int) -> tuple[int, int]:
    if word in {0, 0xFFFFFFFF}:
        return NO_ANSWER, 0
    fault, reasons = word >> 16 & 1, word & 7
    if word >> 17 & 1 or word >> 3 & 1 or bool(fault) != bool(reasons):
        return CRC, 0
    if fault:
        return (OPEN if reasons & 1 else SHORT), 0
    raw = word >> 18
    return VALID, raw - (1 << 14) if raw >> 13 else raw


ANSWERS: dict[str, tuple[Judged, int, tuple[int, ...]]] = {
    "max6675": (judged_6675, 16, (15, 2, 1)),
    "max31855": (judged_31855, 32, (17, 16, 3, 2, 1, 0)),
}
"""Who judges a chip's answer, its bits, and those that are zero in most."""


def words(chance: Random, bits: int, often_zero: tuple[int, ...], count: int) -> list[int]:
    """Draw any word, and more of those that are almost good; all ones and zeros, and every bit."""
    mask = ~sum(1 << bit for bit in often_zero)
    drawn = [chance.getrandbits(bits) for _ in range(count)]
    good = [word & mask for word in drawn]
    flipped = [word ^ 1 << chance.choice(often_zero) for word in good]
    full = (1 << bits) - 1
    edges = [0, 1, 2, full, full - 1, full ^ 1 << (bits - 1), 1 << (bits - 1)]
    alone = [400 << bits - 14 | 1 << one | 1 << two for one in often_zero for two in often_zero]
    return [*edges, *alone, *drawn, *good, *flipped]


def answers_problem(bench: Crucible, answers: Iterable[int], judged: Judged) -> str:
    _, raw = bench.read(2)[-1]
    for word in answers:
        status, code = judged(word)
        raw = raw if status else code
        if (found := bench.answered(word)) != (status, raw):
            return f"{word:#x} is {found}, not {(status, raw)}"
    return ""


def short_problem(bench: Crucible) -> str:
    bench.sense(100.0)
    bench.steps(3)
    bench.chip.short("low")
    if bench.statuses(2) != [SHORT, SHORT]:
        return "a short of its answers"
    bench.chip.short(None)
    if bench.statuses(3)[1:] != [VALID, VALID]:
        return "after a short"
    bench.chip.unplug()
    return "" if bench.statuses(3)[-1] in {NO_ANSWER, STALE} else "a chip that is not there"


SETTINGS = bytes.fromhex("91 03 FF 7F C0 7F FF 80 00 00")
POWER_ON = bytes.fromhex("00 03 FF 7F C0 7F FF 80 00 00 00 00 00 00 00 00")
"""CR0 to CJTO as they should be: automatic, with the open test, 50 Hz; type K, no averaging."""
LATE = bytes.fromhex("80 07 00 01 02 03 04 05 06 07")
"""What an earlier firmware may have left: it converts, filters 60 Hz, takes its wire for type T."""
CR1, CJTO, CJTL, LTCBH, LTCBL, SR = 1, 9, 11, 12, 14, 15
ALONE = 0, 1, 6, 7, 12, 13, 15, 16, 23, 24, 31, 33, 34, 39, 40, 47  # at the ends of values
SHORTEST_S = 0.31
"""The period after which, behind a set-up, no reading is in time for the next step."""


def judged_31856(registers: bytes) -> tuple[int, int]:
    if len(set(registers)) == 1 and registers[0] in {0, 0xFF}:
        return NO_ANSWER, 0
    if registers[: CJTO + 1] != SETTINGS:
        return (RESET if registers[: CJTO + 1] == POWER_ON[: CJTO + 1] else CRC), 0
    said = bytearray(registers[CJTO + 1 :])
    said[CJTL - CJTO - 1] &= 0xFC
    said[LTCBL - CJTO - 1] &= 0xE0
    if not any(said):
        return NO_ANSWER, 0
    for bits, status in ((0x02, SHORT), (0x01, OPEN), (0xC0, RANGE)):
        if registers[SR] & bits:
            return status, 0
    return VALID, int.from_bytes(registers[LTCBH:SR], "big", signed=True) >> 5


def registers_said(count: int) -> list[bytes]:
    """Return answers of each sort, then any, and more of those that are almost good."""
    said = ("19 00 01 40 00 01", "19 00 01 40 00 41", "19 00 01 40 00 40", "19 00 01 40 00 80",
            "19 00 01 40 00 03", "19 00 00 00 00 00", "19 03 01 40 1F 00", "00 00 00 00 00 00",
            "00 03 00 00 1F 00", "19 00 FF FF E0 00")  # fmt: skip
    found = [SETTINGS + bytes.fromhex(each) for each in said]
    found += [SETTINGS + (1 << bit).to_bytes(6) for bit in ALONE]
    found += [bytes(16), b"\xff" * 16, POWER_ON, SETTINGS[:9] + b"\x01" + found[0][10:]]
    found += [POWER_ON[:9] + b"\x01" + POWER_ON[10:], POWER_ON[:1] + b"\x13" + POWER_ON[2:]]
    found += [b"\x11" + POWER_ON[1:], b"\x01" + POWER_ON[1:], SETTINGS + POWER_ON[10:]]
    found += [SETTINGS[:1] + bytes([SETTINGS[1] ^ 1]) + SETTINGS[2:] + POWER_ON[CJTO + 1 :]]
    chance = Random(7)  # noqa: S311 - no secret
    for _ in range(count):
        drawn = bytearray(SETTINGS + chance.randbytes(6))
        drawn[SR] &= chance.choice((0x00, 0x3C, 0xFF))
        found.append(bytes(drawn))
        place = chance.choice((CR1, CJTO, CJTL, LTCBL, chance.randrange(16)))
        drawn[place] ^= 1 << chance.randrange(8)
        found += [bytes(drawn), chance.randbytes(16)]
    return found


def set_up_problem(bench: Crucible) -> str:
    """Power on beside a chip that was told otherwise: it is set up, and a reading is awaited."""
    bench.chip.was_told(LATE)
    bench.sense(30.0)
    due = [(STALE, 0), (VALID, 30 * 128), (VALID, 30 * 128)]
    if (found := bench.read(3)) != due:
        return f"first readings {found}"
    if bench.chip._registers[: len(SETTINGS)] != SETTINGS or bench.chip.orders != 2:
        return f"settings {bench.chip._registers.hex()} after {bench.chip.orders} orders"
    return "misused" if bench.chip.misused else ""


def registers_problem(bench: Crucible, answers: Iterable[bytes]) -> str:
    """Let it answer each of these once: what is set up anew is so at once, and nothing else is."""
    bench.sense(30.0)
    chip, raw, sound = bench.chip, bench.read(3)[-1][1], (VALID, 30 * 128)
    for answer in answers:
        orders = chip.orders
        status, code = judged_31856(answer)
        raw = raw if status else code
        if (found := bench.answered(int.from_bytes(answer, "big"))) != (status, raw):
            return f"{answer.hex()} is {found}, not {(status, raw)}"
        anew = status in {NO_ANSWER, RESET, CRC}
        if (found := bench.read(2)) != ([(STALE, raw), sound] if anew else [sound, sound]):
            return f"{answer.hex()}: then {found}"
        raw = sound[1]
        if chip.orders != orders + 2 * anew:
            return f"{answer.hex()}: {chip.orders - orders} orders"
    wrong = chip.port.violations or chip.misused
    return f"{chip.port.phases}, {chip.misused}" if wrong else ""


SPEED = [("uno", ""), ("leonardo", ""), ("mega2560", ""), ("atmega1284p", ""),
         ("atmega1284p", ", clock: 20 MHz"), ("atmega1284p", ", clock: 8 MHz")]  # fmt: skip
MOST_US = 100.0
MOST_MASKED_US = 20.0

of_all = pytest.mark.parametrize("kind", KINDS)
of_both = pytest.mark.parametrize("kind", ANSWERS)


@of_all
@pytest.mark.parametrize(("board", "clock"), SPEED)
def test_it_keeps_to_the_data_sheet_and_reads_in_time(kind: str, board: str, clock: str) -> None:
    bench = Crucible(crucible(kind, board, clock=clock))
    profile = bench.device.avr.profile(bench.device.elf)
    assert bench.statuses(10) == [VALID] * 10
    chip = bench.chip
    assert (chip.reads, chip.port.violations) == (10, 0)
    phases = {"setup", "high", "low", "period", "read", "hold", "idle"}
    if kind == "max31856":
        phases |= {"told", "kept"}
        assert (chip.orders, chip.misused) == (2, 0)
    assert set(chip.port.phases) == phases
    us = 1e6 / bench.device.avr.clock_hz
    assert profile.functions["sensor_tip_tick"].longest * us < MOST_US
    wires = [each for name, each in profile.functions.items() if name.startswith("spi_tip")]
    assert max(each.masked for each in wires) * us < MOST_MASKED_US


@of_all
@pytest.mark.parametrize("board", PINS)
def test_temperatures_over_its_range(kind: str, board: str) -> None:
    bench = Crucible(crucible(kind, board))
    assert reading_problem(bench, 60) == ""


@of_both
def test_any_answer(kind: str) -> None:
    judged, bits, often_zero = ANSWERS[kind]
    drawn = words(Random(7), bits, often_zero, 60)  # noqa: S311 - no secret
    assert answers_problem(Crucible(crucible(kind)), drawn, judged) == ""
    seen = {judged(word)[0] for word in drawn}
    assert seen == ({VALID, NO_ANSWER, CRC, OPEN} | ({SHORT} if kind == "max31855" else set()))


WIRED = {
    ("data", "low"): SHORT,
    ("data", "high"): NO_ANSWER,
    ("select", "high"): NO_ANSWER,  # as a broken wire with a pull-up at the chip
    ("clock", "low"): NO_ANSWER,  # the first bit is 0, and no other comes
}
SELECTED = {("select", "low"): SHORT}  # it never lets go of the data line, whose first bit is 0
WITH_REGISTERS = {
    ("clock", "high"): NO_ANSWER,
    ("told", "low"): VALID,  # every answer begins with the first register: it asks for that
    ("told", "high"): NO_ANSWER,
}
"""What a broken or shorted wire reads; which of them look alike."""


@pytest.mark.parametrize(
    ("kind", "wire", "due"),
    [
        (kind, *each)
        for kind in KINDS
        for each in (WIRED | (WITH_REGISTERS if kind == "max31856" else SELECTED)).items()
    ],
)
def test_each_wire(kind: str, wire: tuple[str, str], due: int) -> None:
    bench = Crucible(crucible(kind))
    bench.sense(100.0)
    assert bench.statuses(3)[1:] == [VALID] * 2
    name, level = wire
    pin = getattr(bench.chip._wires, name)
    bench.device.avr.pins.drive(pin, level)  # type: ignore[arg-type]
    found = bench.statuses(2)
    assert found[-1] == due
    assert kind == "max31856" or found[0] == due
    bench.device.avr.pins.drive(pin, None)
    assert bench.statuses(3)[-1] == VALID


@pytest.mark.parametrize(("kind", "period_s"), [("max6675", 0.23), ("max31855", 0.2)])
def test_the_shortest_period(kind: str, period_s: float) -> None:
    """A reading in every step from the first that can have one; conversions come to their end."""
    bench = Crucible(crucible(kind, period_s=period_s))
    device = bench.device
    for turn in range(20):
        bench.sense(100.0 + turn)
        device.advance((turn + 1) * period_s + 0.01)
    steps = device.steps("crucible")
    late = 0 if kind == "max6675" else 1
    assert steps["reading_status"].tolist() == [STALE] * late + [VALID] * (20 - late)
    wanted = [4 * (100 + max(turn - 1, 0)) for turn in range(20)]
    assert (abs(steps["reading_raw"] - np.array(wanted))[2:] <= 4).all()


@of_both
def test_the_readme_says_how_to_wire_it(kind: str) -> None:
    """Without these a broken thermocouple is not seen, or a good one is taken for a short."""
    text = files_of(crucible(kind))["README.md"]
    rows = [line for line in text.splitlines() if "sensor `tip`" in line]
    assert [row.split(" = ")[0] for row in rows[:3]] == ["| D10", "| D8", "| D12"]
    wanted = {"max6675": "T- to its ground", "max31855": "must not touch ground"}
    assert wanted[kind] in rows[3]
    assert ("level shifter" in rows[0]) == (kind == "max31855")


@pytest.mark.parametrize("letter", "BEJKNRST")
@pytest.mark.parametrize(("average", "mains"), [(1, 60), (2, 50), (4, 60), (16, 50)])
def test_every_setting(letter: str, average: int, mains: int) -> None:
    extra = f", thermocouple: {letter}, average: {average}, mains_filter: {mains} Hz"
    bench = Crucible(crucible("max31856", period_s=0.35 if average == 1 else 1, extra=extra))
    celsius = 640 if letter == "B" else 240
    bench.sense(celsius)
    bench.device.advance(4.0)
    log = bench.device.steps("crucible")
    assert set(log["reading_status"][1:]) <= {VALID}
    assert log["reading_raw"][-1] == celsius * 128
    code = {1: 0, 2: 1, 4: 2, 16: 4}[average]
    settings = [0x90 | (mains == 50), code << 4 | "BEJKNRST".index(letter)]
    assert (bench.chip._registers[:2], bench.chip.misused) == (bytes(settings), 0)


def test_a_max31856_is_set_up_and_answers_anything() -> None:
    """Settings that are not as they were written are written again: then it must read once more."""
    brisk = Crucible(crucible("max31856", period_s=SHORTEST_S))
    assert set_up_problem(brisk) == ""
    answers = registers_said(60)
    assert registers_problem(brisk, answers) == ""
    seen = {judged_31856(answer)[0] for answer in answers}
    assert seen == {VALID, NO_ANSWER, SHORT, CRC, RESET, OPEN, RANGE}


def test_never_told_it_never_converts() -> None:
    """Its input is at ground from the start: it keeps the settings of its power-up."""
    bench = Crucible(crucible("max31856"))
    bench.chip.short_orders("low")
    bench.steps()
    bench.chip.brown_out()
    assert set(bench.statuses(6)[1:]) == {RESET}


@of_all
@pytest.mark.parametrize("early_s", np.arange(0.0, 0.08, 0.01))
def test_a_reset_of_the_controller_in_the_middle_of_an_answer(kind: str, early_s: float) -> None:
    """The chip goes on, selected or not; it is set up anew, and no reading is wrong."""
    bench = Crucible(crucible(kind))
    device = bench.device
    bench.sense(77.0)
    device.advance(4 * bench.period_s - early_s + 0.0005)
    device.avr.reset("external")
    device.advance(device.time_s + 4 * bench.period_s)
    log, steps = device.steps("crucible"), STEPS_PER_K[kind]
    good = log["reading_raw"][log["reading_status"] == VALID]
    assert set(good.tolist()) <= {20 * steps, 77 * steps}
    assert log["reading_status"][-1] == VALID
    assert kind != "max31856" or bench.chip.misused == 0


SPEC = """
heatwright: 1
controller: {{name: baths, board: uno}}
sensors:
  left: {{kind: ds18b20, pin: A1, resolution: {0} bit}}
  right: {{kind: ds18b20, pin: A2, resolution: {1} bit}}
outputs: {{left: {{kind: digital, pin: D3}}, right: {{kind: digital, pin: D4}}}}
loops:
  left: {{sensor: left, heater: left, period: {2} ms, algorithm: {{kind: on_off}}, {4}}}
  right: {{sensor: right, heater: right, period: {3} ms, algorithm: {{kind: on_off}}, {4}}}
"""
HOT = "setpoint: {initial: 90 °C, minimum: 10 °C, maximum: 95 °C}, protection: {stale_after: 6 s}"


def held(device: AvrDevice, felt_c: float, **faults: Any) -> list[Any]:
    """Cut the power, go on with such chips, and return the steps of each loop."""
    device.power_cycle()
    done = {name: len(device.steps(name)) for name in device.sensors}
    for chip in device.sensors.values():
        chip.undefined_bits = 0
        chip.sense(felt_c)
        vars(chip.faults).update(faults)
    device.advance(device.time_s + 14.05)
    return [device.steps(name)[first:] for name, first in done.items()]


@pytest.mark.parametrize("bits", range(9, 13))
def test_a_power_cut_at_85_degrees(bits: int) -> None:
    text = SPEC.format(bits, 21 - bits, 350 << bits - 9, 350 << 12 - bits, HOT)
    device = device_of(text)
    for steps in held(device, 85.0) + held(device, 85.0):
        assert ({*steps["reading_status"]}, {*steps["temperature_c"]}) == ({0}, {85.0})
    assert (device.read("fault.code"), device.outputs["left"].on) == (0, True)
    for faults in ({"idle": True}, {"weak": True}, {"slow": 5.5}):
        for steps in held(device, 20.0, **faults):  # none of these chips is believed
            measured = steps["reading_status"] == 0
            assert {*steps["reading_status"][~measured]} == {5}
            assert {*steps["reading_raw"][measured]} == ({320} if "slow" in faults else set())


def test_an_exchange_that_has_lost_its_place_ends() -> None:
    """A bit that flips in RAM must not have it write all over the memory until it finds its end."""
    text = SPEC.format(12, 12, 1000, 1000, HOT)
    device = device_of(text)
    place = device.variables["one_wire_left.index"]
    device.advance(0.1)
    while not (device.read("one_wire_left.busy") and device.read("one_wire_left.index") > 2):
        device.advance(device.time_s + 0.0003)
    device.avr.write_ram(place.address, bytes([int(device.read("one_wire_left.size")) + 1]))
    device.advance(device.time_s + 0.002)
    assert not device.read("one_wire_left.busy")
