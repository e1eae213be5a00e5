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
    "D4": "the display's data 4",
    "D5": "the display's data 5",
    "D6": "the display's data 6",
    "D7": "the display's data 7",
    "D8": "the display's RS",
    "D9": "the display's E",
    "D10": "the display's backlight",
    "A0": "the keys",
}


class PinUse(NamedTuple):
    """One use of one pin."""

    pin: Pin
    path: Path
    purpose: str
    """What an interface uses it for; empty for a sensor or an output."""


def pin_uses(controller: Controller) -> Iterator[PinUse]:
    """List the uses of pins in the order of the file; names that are no pins are left out."""
    board = controller.board
    for section, parts in (("sensors", controller.sensors), ("outputs", controller.outputs)):
        for name, part in parts.items():
            pin = board.pins.get(part.pin)
            if pin is not None:
                yield PinUse(pin, (section, name, "pin"), "")
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
