"""The EEPROM of the chamber: no content of it heats or hangs. What is kept: tests/storage."""

import random

import pytest
from chamber_on import HEATER, ROOM_C, power_on
from suite import amount

IN_A_TEST = 50


@pytest.mark.parametrize("first", range(0, amount("eeprom_images"), IN_A_TEST))
def test_random_contents_never_heat_nor_hang(first: int) -> None:
    """Noise, and runs of one byte: all are refused."""
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
    runs = (bytes([chance.randrange(255)]) * chance.randrange(1, 200) for _ in range(size))
    return b"".join(runs)[:size]
