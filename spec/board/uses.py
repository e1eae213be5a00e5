"""The pins that a spec uses, and their purposes."""

from collections.abc import Iterator
from typing import NamedTuple

from heatwright.spec.base import PIN_MARK
from heatwright.spec.boards import Board, Pin, Uart
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import Interface
from heatwright.spec.outputs import Output
from heatwright.spec.problems import Path
from heatwright.spec.sensors import Sensor

SERIAL_PORT = "the serial port"


class PinUse(NamedTuple):
    """One use of one pin."""

    pin: Pin
    path: Path
    purpose: str
    """What an interface or a contact uses the pin for; empty for a sensor's or an output's pin."""


def pin_uses(controller: Controller) -> Iterator[PinUse]:
    """List the uses of pins in the order of the file; names that are no pins are left out."""
    board = controller.board
    for path, pin_name, purpose in wired_pins(controller):
        if pin_name in board.pins:
            yield PinUse(board.pins[pin_name], path, purpose)
    for index, interface in enumerate(controller.interfaces):
        for keys, name, purpose in interface_pins(board, interface):
            if name in board.pins:
                yield PinUse(board.pins[name], ("interfaces", index, *keys), purpose)


def wired_pins(controller: Controller) -> Iterator[tuple[Path, str, str]]:
    """List the pins of sensors, outputs and contacts: path, name and purpose.

    The purpose of a sensor's or an output's own pin is empty.
    """
    for section, parts in (("sensors", controller.sensors), ("outputs", controller.outputs)):
        for name, part in parts.items():
            for key, pin_name in _pins_of(part).items():
                yield (section, name, key), pin_name, ""
    for name, output in controller.outputs.items():
        if output.proof is not None:
            yield ("outputs", name, "proof", "pin"), output.proof.pin, "the signal that a fan turns"
    if (feedback := controller.safety.relay_feedback) is not None:
        yield ("safety", "relay_feedback"), feedback, "the relay's feedback"
    for name, each in controller.safety.inputs.items():
        yield ("safety", "inputs", name, "pin"), each.pin, f"the input {name}"


def _pins_of(part: Sensor | Output) -> dict[str, str]:
    """List a sensor's or an output's pins by their keys: `pin`, or several."""
    return {
        field.alias or name: getattr(part, name)
        for name, field in type(part).model_fields.items()
        if PIN_MARK in field.metadata
    }


def interface_pins(board: Board, interface: Interface) -> Iterator[tuple[Path, str, str]]:
    """List an interface's pins: the path of the key that names it, if any, the pin, its purpose."""
    if interface.shield is not None:
        for name, purpose in interface.shield.pins.items():
            yield (), name, purpose
    uart = uart_of(board, interface)
    if uart is not None:
        for name in (uart.tx, uart.rx):
            yield (), name, SERIAL_PORT
    yield from interface.named_pins


def uart_of(board: Board, interface: Interface) -> Uart | None:
    """Find the serial port of an interface; None if it has none, or one that the board lacks."""
    line = interface.line
    return None if line is None or line.port >= len(board.uarts) else board.uarts[line.port]
