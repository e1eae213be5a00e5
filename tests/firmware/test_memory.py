"""The EEPROM: every cell wears alike, and no power cut and no content gets through."""

import random

import pytest
from eeprom_records import SIZE, SLOTS, decoded, record, ring
from powered import PowerOn

from heatwright.sim.native.pins import pin_number
from heatwright.spec import Controller
from heatwright.spec.rules import RULES

LAST = 16
"""Last rule that the chamber has: its sensor is a chip, and no host stops it."""

IMAGES = 500
IN_A_TEST = 50
SAVE_S = 0.3


def test_every_cell_wears_alike(power_on: PowerOn, chamber: Controller) -> None:
    """Faults and acknowledgements until the ring has gone round: each slot is used in turn."""
    device = power_on()
    device.advance(0.2)
    code = device.variables["fault.code"].address
    sequence = []
    for turn in range(SLOTS + 5):
        before = decoded(chamber, device.avr.eeprom.contents)
        device.avr.write_ram(code, bytes([1]))
        device.press("select")
        device.advance(device.time_s + SAVE_S)
        device.press(None)
        device.advance(device.time_s + SAVE_S)
        after = decoded(chamber, device.avr.eeprom.contents)
        (changed,) = [slot for slot in after if before.get(slot) != after[slot]]
        sequence.append(changed)
        assert after[changed][1] == 0, turn
    assert sequence == [(1 + turn) % SLOTS for turn in range(SLOTS + 5)]
    assert device.avr.eeprom.writes == SIZE * (SLOTS + 5)
    assert device.avr.eeprom.violations == 0


@pytest.mark.parametrize("undefined", [0x00, 0xFF, 0x5A])
@pytest.mark.parametrize("byte", range(SIZE))
def test_a_power_cut_leaves_the_old_or_the_new(
    power_on: PowerOn, byte: int, undefined: int
) -> None:
    device = power_on()
    device.advance(2.5)
    device.sensors["air"].short("low")  # type: ignore[attr-defined]
    while not (device.avr.eeprom.writes == byte + 1 and device.avr.eeprom.writing):
        device.advance(device.time_s + 0.002)
        assert device.time_s < 10
    device.power_cycle(undefined)
    device.sense("air", 19.0)
    device.advance(device.time_s + 0.5)
    # The last byte, a CRC's, may have become right by chance.
    assert device.read("fault.code") in ({0} if byte < SIZE - 1 else {0, 2})


@pytest.mark.parametrize("code", range(1, LAST + 1))
def test_a_fault_that_is_stored_is_latched_and_shown(
    power_on: PowerOn, chamber: Controller, code: int
) -> None:
    device = power_on(eeprom=record(chamber, 1, code, 85.0, 1234))
    device.advance(5.0)
    assert device.read("fault.code") == code
    assert device.read("fault.temperature_c") == 85.0
    assert device.read("fault.time_s") == 1234
    assert device.shield.lcd.text[1].rstrip() == f"E{code:02d} {RULES[code].display}"
    assert device.avr.pins.high_cycles(pin_number("PD3")) == 0


@pytest.mark.parametrize("code", [LAST + 1, 100, 255])
def test_a_code_that_no_rule_has(power_on: PowerOn, chamber: Controller, code: int) -> None:
    device = power_on(eeprom=record(chamber, 1, code))
    device.advance(5.0)
    assert device.read("fault.code") == 16
    assert device.shield.lcd.text[1] == "E16 SETTINGS BAD"


def test_records_of_other_firmware_count_for_nothing(
    power_on: PowerOn, chamber: Controller
) -> None:
    other = chamber.model_copy(
        update={"safety": chamber.safety.model_copy(update={"watchdog_s": 1.0})}
    )
    device = power_on(eeprom=ring(record(other, number, 6) for number in range(SLOTS)))
    device.advance(2.0)
    assert device.read("fault.code") == 0


@pytest.mark.parametrize("first", range(0, IMAGES, IN_A_TEST))
def test_random_contents_never_heat_nor_hang(power_on: PowerOn, first: int) -> None:
    """Noise, runs of one byte, single flipped bits of good records: all are refused or harmless."""
    device = power_on()
    for seed in range(first, first + IN_A_TEST):
        chance = random.Random(seed)  # noqa: S311 - noise, not a secret
        device.avr.eeprom.contents = _image(chance, device.avr.eeprom.size)
        device.power_cycle()
        device.sense("air", 19.0)
        began_s = device.time_s
        device.advance(began_s + 2.6)
        assert device.read("fault.code") == 16, seed
        assert device.read("loop_air.steps") == 2, seed
        assert device.avr.pins.high_cycles(pin_number("PD3")) == 0, seed


def _image(chance: random.Random, size: int) -> bytes:
    if chance.random() < 0.5:
        return chance.randbytes(size)
    image = b""
    while len(image) < size:
        image += bytes([chance.randrange(255)]) * chance.randrange(1, 200)
    return image[:size]
