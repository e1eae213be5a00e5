"""The boards' data against two others who wrote it down: avr-libc and Arduino."""

import re
import subprocess
from functools import cache
from pathlib import Path

import pytest

from heatwright.spec import BOARDS, Board

VARIANTS = Path("/usr/share/arduino/hardware/arduino/avr/variants")
BY_VARIANT = {"uno": "standard", "mega2560": "mega", "leonardo": "leonardo"}
CHIPS = sorted({board.mcu for board in BOARDS.values()})


@cache
def preprocessed(mcu: str, *words: str) -> str:
    command = ["avr-gcc", f"-mmcu={mcu}", "-E", "-x", "c", *words]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


@cache
def macros(mcu: str) -> dict[str, str]:
    """All that avr-libc defines of a chip."""
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
    assert board.flash_bytes == value(mcu, "FLASHEND") + 1
    assert board.ram_start == value(mcu, "RAMSTART")
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
        assert board.pins[uart.rx].serial == "rx"
        assert board.pins[uart.tx].serial == "tx"
    assert [pin.name for pin in pins if pin.led] == ([] if board.bootloader_bytes == 0 else ["D13"])
    assert any(pin.bootloader for pin in pins) == (board.bootloader_bytes > 0)
    assert board.clock_hz <= board.fastest_hz
    if board.shield:
        assert {f"D{n}" for n in range(14)} | {f"A{n}" for n in range(6)} <= set(board.pins)


def test_channels_of_the_keys() -> None:
    """A0 is another channel on a Leonardo."""
    assert [BOARDS[name].pins["A0"].adc for name in BY_VARIANT] == [0, 0, 7]
