"""The firmware's reader on several boards and crystals, and what it makes of any answer."""

import random

import numpy as np
import pytest
from max31856_specs import PINS, program, spec_of

from heatwright.sim.device import AvrDevice
from heatwright.sim.replay import replay
from heatwright.sim.sensors.max31856 import Max31856

PERIOD_S = 0.35
AFTER_S = 0.02
"""We look so long after a step is due."""
SPEED = [("uno", ""), ("leonardo", ""), ("mega2560", ""), ("atmega1284p", ""),
         ("atmega1284p", ", clock: 20 MHz"), ("atmega1284p", ", clock: 8 MHz")]  # fmt: skip
MOST_US = 100.0
MOST_MASKED_US = 20.0
VALID, NO_ANSWER, SHORT, CRC, STALE, RESET, OPEN, RANGE = 0, 1, 2, 3, 4, 5, 17, 18
SETTINGS = bytes.fromhex("91 03 FF 7F C0 7F FF 80 00 00")
POWER_ON = bytes.fromhex("00 03 FF 7F C0 7F FF 80 00 00 00 00 00 00 00 00")
"""CR0 to CJTO as they should be: automatic, with the open test, 50 Hz; type K, no averaging."""
CR1, CJTO, CJTL, LTCBH, LTCBL, SR = 1, 9, 11, 12, 14, 15


def crucible(board: str = "uno", *, clock: str = "", extra: str = "") -> tuple[AvrDevice, Max31856]:
    device = AvrDevice(
        spec_of(board, clock=clock, extra=extra).controller,
        program(board, clock=clock, extra=extra),
    )
    chip = device.sensors["tip"]
    assert isinstance(chip, Max31856)
    device.advance(AFTER_S)
    return device, chip


def next_steps(device: AvrDevice, count: int = 1) -> np.ndarray:
    """Run so many periods, and return their steps."""
    done = len(device.steps("crucible"))
    device.advance(device.time_s + count * PERIOD_S)
    return device.steps("crucible")[done:]


@pytest.mark.parametrize(("board", "clock"), SPEED)
def test_it_keeps_to_the_data_sheet_and_reads_in_time(board: str, clock: str) -> None:
    device, chip = crucible(board, clock=clock)
    profile = device.avr.profile(device.elf)
    device.advance(10 * PERIOD_S + AFTER_S)
    steps = device.steps("crucible")
    assert steps["reading_status"].tolist() == [VALID] * 10
    assert (chip.reads, chip.orders, chip.misused) == (10, 2, 0)
    assert chip.port.violations == 0
    assert {"setup", "high", "low", "period", "read", "hold", "idle", "told", "kept"} == set(
        chip.port.phases
    )
    us = 1e6 / device.avr.clock_hz
    assert profile.functions["sensor_tip_tick"].longest * us < MOST_US
    wires = [each for name, each in profile.functions.items() if name.startswith("spi_tip")]
    assert max(each.masked for each in wires) * us < MOST_MASKED_US


@pytest.mark.parametrize("board", PINS)
def test_temperatures_over_its_range(board: str) -> None:
    """The nearest code, after every change in time for the next step but one."""
    device, _ = crucible(board)
    for temperature_c in np.linspace(-199.9, 1371.9, 60):
        device.sense("tip", float(temperature_c))
        last = next_steps(device, 2)[-1]
        assert last["reading_status"] == VALID
        assert last["reading_raw"] == np.floor(128 * temperature_c + 0.5)
        assert last["temperature_c"] == np.float32(last["reading_raw"] / 128)


@pytest.mark.parametrize("letter", "BEJKNRST")
@pytest.mark.parametrize(("average", "mains"), [(1, 60), (2, 50), (4, 60), (16, 50)])
def test_every_setting(letter: str, average: int, mains: int) -> None:
    period = "350 ms" if average == 1 else "1 s"
    asked = {"extra": f", thermocouple: {letter}, average: {average}, mains_filter: {mains} Hz"}
    device = AvrDevice(spec_of(period=period, **asked).controller, program(period=period, **asked))
    chip = device.sensors["tip"]
    assert isinstance(chip, Max31856)
    device.sense("tip", 640.0 if letter == "B" else 240.0)
    device.advance(4.0)
    log = device.steps("crucible")
    assert set(log["reading_status"][1:]) <= {VALID}
    assert log["reading_raw"][-1] == (640 if letter == "B" else 240) * 128
    code = {1: 0, 2: 1, 4: 2, 16: 4}[average]
    assert chip._registers[:2] == bytes(
        [0x90 | (mains == 50), code << 4 | "BEJKNRST".index(letter)]
    )
    assert chip.misused == 0


def judged(registers: bytes) -> tuple[int, int]:
    """Status and raw code, after the data sheet's list of the registers."""
    if len(set(registers)) == 1 and registers[0] in {0, 0xFF}:
        return NO_ANSWER, 0
    if registers[: CJTO + 1] != SETTINGS:
        return (RESET if registers[: CJTO + 1] == POWER_ON[: CJTO + 1] else CRC), 0
    said = bytearray(registers[CJTO + 1 :])
    said[CJTL - CJTO - 1] &= 0xFC
    said[LTCBL - CJTO - 1] &= 0xE0
    if not any(said):
        return NO_ANSWER, 0
    faults = registers[SR]
    for bits, status in ((0x02, SHORT), (0x01, OPEN), (0xC0, RANGE)):
        if faults & bits:
            return status, 0
    return VALID, int.from_bytes(registers[LTCBH:SR], "big", signed=True) >> 5


def answers(count: int) -> list[bytes]:
    """Any answer, and more of those that are almost good."""
    chance = random.Random(7)  # noqa: S311 - no secret
    found = [bytes(16), b"\xff" * 16, SETTINGS + bytes(6), POWER_ON]
    found += [SETTINGS + bytes([0, 3, 0, 0, 0x1F, 0]), SETTINGS + bytes([0, 0, 0, 0, 0x20, 0])]
    found += [POWER_ON[:CJTO] + bytes([1]) + POWER_ON[CJTO + 1 :], bytes([1]) + POWER_ON[1:]]
    found += [SETTINGS[:1] + bytes([SETTINGS[1] ^ 1]) + SETTINGS[2:] + POWER_ON[CJTO + 1 :]]
    for _ in range(count):
        drawn = bytearray(SETTINGS + chance.randbytes(6))
        drawn[SR] &= chance.choice((0x00, 0x3C, 0xFF))
        found.append(bytes(drawn))
        place = chance.choice((CR1, CJTO, CJTL, LTCBL, chance.randrange(16)))
        drawn[place] ^= 1 << chance.randrange(8)
        found.append(bytes(drawn))
        found.append(chance.randbytes(16))
    return found


def test_any_answer() -> None:
    """Settings that are not as they were written are written again: then it must read once more."""
    device, chip = crucible()
    raw, seen = next_steps(device)[-1]["reading_raw"], set()
    for answer in answers(60):
        next_steps(device, 2)  # set up, and converted
        chip._word = lambda answer=answer: int.from_bytes(answer, "big")  # type: ignore[method-assign,misc]
        last = next_steps(device)[-1]
        del chip._word
        status, code = judged(answer)
        raw = raw if status else code
        assert last["reading_status"] == status, answer.hex()
        if not status:
            assert last["reading_raw"] == raw
        seen.add(status)
    assert seen == {VALID, NO_ANSWER, SHORT, CRC, RESET, OPEN, RANGE}


def test_each_wire() -> None:
    """What a broken or shorted wire reads; which of them look alike."""
    found = {}
    for name, level in (
        ("select", "high"), ("clock", "low"), ("clock", "high"), ("data", "low"),
        ("data", "high"), ("told", "low"), ("told", "high"),
    ):  # fmt: skip
        device, chip = crucible()
        next_steps(device, 2)
        device.avr.pins.drive(getattr(chip._wires, name), level)
        found[name, level] = int(next_steps(device, 2)[-1]["reading_status"])
    assert found == {
        ("select", "high"): NO_ANSWER,
        ("clock", "low"): NO_ANSWER,
        ("clock", "high"): NO_ANSWER,
        ("data", "low"): SHORT,
        ("data", "high"): NO_ANSWER,
        ("told", "low"): VALID,  # every answer begins with the first register: it asks for that
        ("told", "high"): NO_ANSWER,
    }


def test_never_told_it_never_converts() -> None:
    """Its input is at ground from the start: it keeps the settings of its power-up."""
    device, chip = crucible()
    chip.short_orders("low")
    next_steps(device)
    chip.brown_out()
    assert set(next_steps(device, 6)["reading_status"][1:]) == {RESET}


def test_an_interrupted_supply_costs_one_reading() -> None:
    device, chip = crucible()
    next_steps(device, 3)
    chip.brown_out()
    status = next_steps(device, 4)["reading_status"].tolist()
    assert status == [RESET, VALID, VALID, VALID]
    assert chip._registers[: CJTO + 1] == SETTINGS


def test_a_reset_of_the_controller_in_the_middle_of_an_answer() -> None:
    """The chip goes on, selected or not; it is set up anew, and no reading is wrong."""
    for early_s in np.arange(0.0, 0.08, 0.01):
        device, chip = crucible()
        device.sense("tip", 77.0)
        device.advance(4 * PERIOD_S - early_s + 0.0005)
        device.avr.reset()
        device.advance(device.time_s + 4 * PERIOD_S)
        log = device.steps("crucible")
        good = log["reading_raw"][log["reading_status"] == VALID]
        assert set(good.tolist()) <= {20 * 128, 77 * 128}
        assert chip.misused == 0


def test_a_replay_is_equal() -> None:
    device, _ = crucible()
    for turn in range(40):
        device.sense("tip", 20.0 + 0.37 * turn)
        next_steps(device)
    result = replay(spec_of().controller, device.steps("crucible"))
    assert result.mismatches == 0
