"""Which pins a spec uses, and for what."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from heatwright.spec.boards import Board, Pin
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import LcdKeypad
from heatwright.spec.problems import Path

# The shield: HD44780 in 4-bit mode without reading back, five keys on one analog pin.
LCD_KEYPAD_PINS = {
    "D4": "data 4 of the display",
    "D5": "data 5 of the display",
    "D6": "data 6 of the display",
    "D7": "data 7 of the display",
    "D8": "RS of the display",
    "D9": "E of the display",
    "D10": "backlight of the display",
    "A0": "keys",
}


class PinUse(NamedTuple):
    """One use of one pin."""

    pin: Pin
    path: Path
    purpose: str


def pin_uses(controller: Controller) -> Iterator[PinUse]:
    """List the uses of pins in the order of the file; names that are no pins are left out."""
    board = controller.board
    for section, parts in (("sensors", controller.sensors), ("outputs", controller.outputs)):
        for name, part in parts.items():
            pin = board.pins.get(part.pin)
            if pin is not None:
                yield PinUse(pin, (section, name, "pin"), f"{section}.{name}")
    for index, interface in enumerate(controller.interfaces):
        for name, purpose in interface_pins(board, interface).items():
            if name in board.pins:
                yield PinUse(board.pins[name], ("interfaces", index), purpose)


def interface_pins(board: Board, interface: object) -> dict[str, str]:
    """List the pins an interface takes, with what for."""
    if isinstance(interface, LcdKeypad):
        return LCD_KEYPAD_PINS
    uart = board.uarts[0]
    return {uart.tx: "the serial port", uart.rx: "the serial port"}
