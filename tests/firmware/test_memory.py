"""The EEPROM: every cell wears alike, and no power cut and no content gets through."""

import random

import pytest
from chamber_on import (
    HEATER,
    RECORD_BYTES,
    ROOM_C,
    SLOTS,
    decoded,
    power_on,
    press,
    put,
    record,
    ring,
)
from suite import amount

from heatwright.spec.rules import RULES

LAST = 16
"""Last rule that the chamber has: its sensor is a chip, and no host stops it."""
IN_A_TEST = 50
SAVE_S = 0.3


def test_every_cell_wears_alike() -> None:
    """Faults and acknowledgements until the ring has gone round: each slot is used in turn."""
    device = power_on()
    device.advance(0.2)
    sequence = []
    for turn in range(SLOTS + 5):
        before = decoded(device.avr.eeprom.contents)
        put(device, "fault.code", 1)
        press(device, "select", SAVE_S)
        device.advance(device.time_s + SAVE_S)
        after = decoded(device.avr.eeprom.contents)
        (changed,) = [slot for slot in after if before.get(slot) != after[slot]]
        sequence.append(changed)
        assert after[changed][1] == 0, turn
    assert sequence == [(1 + turn) % SLOTS for turn in range(SLOTS + 5)]
    assert device.avr.eeprom.writes == RECORD_BYTES * (SLOTS + 5)
    assert device.avr.eeprom.violations == 0


@pytest.mark.parametrize("undefined", [0x00, 0xFF, 0x5A])
@pytest.mark.parametrize("byte", range(RECORD_BYTES))
def test_a_power_cut_leaves_the_old_or_the_new(byte: int, undefined: int) -> None:
    device = power_on()
    device.advance(2.5)
    device.sensors["air"].short("low")  # type: ignore[attr-defined]
    while not (device.avr.eeprom.writes == byte + 1 and device.avr.eeprom.writing):
        device.advance(device.time_s + 0.002)
        assert device.time_s < 10
    device.power_cycle(undefined)
    device.sense("air", ROOM_C)
    device.advance(device.time_s + 0.5)
    # The last byte, a CRC's, may have become right by chance.
    assert device.read("fault.code") in ({0} if byte < RECORD_BYTES - 1 else {0, 2})


@pytest.mark.parametrize("code", [*range(1, LAST + 1), LAST + 1, 100, 255])
def test_a_fault_that_is_stored_is_latched_and_shown(code: int) -> None:
    """A code that no rule has is a record that nobody wrote."""
    device = power_on(record(1, code, 85.0, 1234))
    device.advance(5.0)
    latched = code if code <= LAST else 16
    assert device.read("fault.code") == latched
    if code <= LAST:
        assert device.read("fault.temperature_c") == 85.0
        assert device.read("fault.time_s") == 1234
    assert device.shield.lcd.text[1].rstrip() == f"E{latched:02d} {RULES[latched].display}"
    assert device.avr.pins.high_cycles(HEATER) == 0


@pytest.mark.parametrize("last", [0, 0x7FFF, 0x8000, 0xFFFE, 0xFFFF])
def test_sequence_numbers_wrap(last: int) -> None:
    """The newest of a full ring is found wherever the numbers are."""
    newest = 11
    codes = [6 if slot == newest else 1 for slot in range(SLOTS)]
    records = (record(last - (newest - slot) % SLOTS, code) for slot, code in enumerate(codes))
    device = power_on(ring(records))
    device.advance(0.5)
    assert device.read("fault.code") == 6
    press(device, "select", 0.5)
    device.advance(2.0)
    assert device.read("fault.code") == 0
    assert decoded(device.avr.eeprom.contents)[newest + 1] == ((last + 1) & 0xFFFF, 0)
    device.power_cycle()
    device.sense("air", ROOM_C)
    device.advance(2.5)
    assert device.read("fault.code") == 0


@pytest.mark.parametrize("first", range(0, amount("eeprom_images"), IN_A_TEST))
def test_random_contents_never_heat_nor_hang(first: int) -> None:
    """Noise, runs of one byte, single flipped bits of good records: all are refused or harmless."""
    device = power_on()
    for seed in range(first, first + IN_A_TEST):
        chance = random.Random(seed)  # noqa: S311 - noise, not a secret
        device.avr.eeprom.contents = _image(chance, device.avr.eeprom.size)
        device.power_cycle()
        device.sense("air", ROOM_C)
        device.advance(device.time_s + 2.6)
        assert device.read("fault.code") == 16, seed
        assert device.read("loop_air.steps") == 2, seed
        assert device.avr.pins.high_cycles(HEATER) == 0, seed


def _image(chance: random.Random, size: int) -> bytes:
    if chance.random() < 0.5:
        return chance.randbytes(size)
    image = b""
    while len(image) < size:
        image += bytes([chance.randrange(255)]) * chance.randrange(1, 200)
    return image[:size]
