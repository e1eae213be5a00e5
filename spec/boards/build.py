"""Puts a board together from its chip's data and the names printed on it."""

from __future__ import annotations

from collections.abc import Mapping

from heatwright.spec.boards.model import Board, Chip, Pin, Uart

SLOW_PRESCALERS = (1, 8, 64, 256, 1024)
FINE_PRESCALERS = (1, 8, 32, 64, 128, 256, 1024)
"""Timer 2's, which can count a clock crystal."""


def ports(widths: Mapping[str, str]) -> tuple[str, ...]:
    """List the pins of ports given as {"B": "0-5"}: PB0, PB1 … PB5."""
    names = []
    for port, bits in widths.items():
        first, last = bits.split("-")
        names += [f"P{port}{bit}" for bit in range(int(first), int(last) + 1)]
    return tuple(names)


def _pin(name: str, port_name: str, functions: str, led: bool, bootloader: bool) -> Pin:
    adc, pwm, serial, spi = None, None, None, None
    for function in functions.split():
        match function[:2]:
            case "ad":
                adc = int(function[3:])
            case "oc":
                pwm = (int(function[2]), function[3:].upper())
            case "rx" | "tx" as line:
                serial = line
            case _:
                spi = function
    return Pin(
        name, port_name[1:2], int(port_name[2:]), adc, pwm, serial, spi, led, bootloader  # type: ignore[arg-type]
    )


def build(
    name: str,
    chip: Chip,
    *,
    platformio: str,
    names: Mapping[str, str] | None = None,
    bootloader_bytes: int = 0,
    bootloader_pins: str = "",
    led: str = "",
    analog_only: Mapping[str, int] | None = None,
    clock_hz: int = 16_000_000,
    shield: bool = False,
) -> Board:
    """Make a board; `names` maps the printed name of each pin to its port's name."""
    names = names or {port_name: port_name for port_name in chip.functions}
    pins = {}
    for printed, port_name in names.items():
        disturbed = printed in bootloader_pins.split()
        pin = _pin(printed, port_name, chip.functions[port_name], printed == led, disturbed)
        pins[printed] = pins[port_name] = pin
    for printed, channel in (analog_only or {}).items():
        pins[printed] = Pin(printed, "", 0, adc=channel)
    return Board(
        name=name,
        mcu=chip.mcu,
        platformio=platformio,
        clock_hz=clock_hz,
        flash_bytes=chip.flash_bytes,
        bootloader_bytes=bootloader_bytes,
        ram_bytes=chip.ram_bytes,
        ram_start=chip.ram_start,
        eeprom_bytes=chip.eeprom_bytes,
        signature=chip.signature,
        pins=pins,
        timers=chip.timers,
        uarts=_uarts(chip, names),
        shield=shield,
    )


def _uarts(chip: Chip, names: Mapping[str, str]) -> tuple[Uart, ...]:
    """Find the serial ports whose both lines the board leads out."""
    lines = {
        function: printed
        for printed, port_name in names.items()
        for function in chip.functions[port_name].split()
        if function[:2] in {"rx", "tx"}
    }
    suffixes = sorted(line[2:] for line in lines if line.startswith("rx"))
    return tuple(Uart(suffix, lines[f"rx{suffix}"], lines[f"tx{suffix}"]) for suffix in suffixes)
