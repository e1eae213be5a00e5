"""Composes a board from its chip's data and the names printed on it."""

from collections.abc import Mapping

from heatwright.spec.boards.model import Board, Chip, Layout, Pin, Uart

SLOW_PRESCALERS = (1, 8, 64, 256, 1024)
FINE_PRESCALERS = (1, 8, 32, 64, 128, 256, 1024)
"""Prescalers of timer 2, which can also count the oscillations of a watch crystal."""


def build(name: str, chip: Chip, layout: Layout) -> Board:
    """Make a board from its chip's data and its layout."""
    names = layout.names or {port_name: port_name for port_name in chip.functions}
    pins = {}
    for printed, port_name in names.items():
        pins[printed] = pins[port_name] = _pin(printed, port_name, chip, layout)
    for printed, channel in layout.analog_only.items():
        pins[printed] = Pin(printed, "", 0, adc=channel)
    uarts = _uarts(chip, names)
    return Board(**vars(chip), **vars(layout), name=name, pins=pins, uarts=uarts)


def _pin(printed: str, port_name: str, chip: Chip, layout: Layout) -> Pin:
    adc, pwm, serial, spi = None, None, None, None
    for function in chip.functions[port_name].split():
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
        name=printed,
        port=port_name[1],
        bit=int(port_name[2]),
        adc=adc,
        pwm=pwm,
        serial=serial,
        spi=spi,
        led=printed == layout.led,
        bootloader=printed in layout.bootloader_pins.split(),
    )


def _uarts(chip: Chip, names: Mapping[str, str]) -> tuple[Uart, ...]:
    """Find the serial ports of which the board has both lines at pins."""
    lines = {
        function: printed
        for printed, port_name in names.items()
        for function in chip.functions[port_name].split()
        if function[:2] in {"rx", "tx"}
    }
    suffixes = sorted(line[2:] for line in lines if line.startswith("rx"))
    return tuple(Uart(suffix, lines[f"rx{suffix}"], lines[f"tx{suffix}"]) for suffix in suffixes)
