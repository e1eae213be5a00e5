"""What stands between a serial port's pins and what is at the other end of its line."""

from __future__ import annotations

from collections.abc import Iterator

from heatwright.generator.plan.pins import label
from heatwright.generator.plan.uart import form
from heatwright.spec import Board, Controller, Gcode, ModbusRtu, SerialLog, SerialPlotter

CALLED = {
    Gcode: "G-code", ModbusRtu: "Modbus", SerialLog: "serial log", SerialPlotter: "serial plotter"
}  # fmt: skip
"""The interfaces whose other end has levels of its own; a Nextion has those of the pins."""

FASTEST_RS232 = 120_000
"""Baud; of a MAX232 (data sheet, data rate)."""

Line = Gcode | ModbusRtu | SerialLog | SerialPlotter


def lines(controller: Controller) -> list[dict[str, str]]:
    """Say for each line, and each kind of line that it may be, which level converter it needs."""
    return [
        {"line": f"{CALLED[type(each)]}, {each.baud} baud, {_form(each)}", "to": to, "needs": needs}
        for each in controller.interfaces
        if isinstance(each, Line)
        for to, needs in _converters(controller.board, each)
    ]


def _form(interface: Line) -> str:
    if isinstance(interface, ModbusRtu):
        return form(interface.parity, interface.stop_bits)
    return "8N1"


def _converters(board: Board, interface: Line) -> Iterator[tuple[str, str]]:
    uart = board.uarts[getattr(interface, "port", 0)]
    to, answers = board.pins[uart.tx], not isinstance(interface, SerialPlotter)
    sent = label(to)
    received = label(board.pins[uart.rx])
    if isinstance(interface, ModbusRtu) and interface.driver_enable is not None:
        direction = label(board.pins[interface.driver_enable])
        yield (
            "RS-485",
            f"a transceiver for 5 V, such as a MAX485: RO to {received}, DI to {sent}, DE and /RE "
            f"to {direction}; 120 Ω between A and B at both ends of the bus, its bias at one",
        )
        return
    if to.bootloader:
        yield "USB", "none: the board's USB socket is this line"
    else:
        heard = f"its TXD to {received}, " * answers
        yield "USB", f"an adapter with levels of 5 V: {heard}its RXD to {sent}, ground to ground"
    heard = f"R1OUT to {received}, " * answers
    if interface.baud <= FASTEST_RS232:
        yield "RS-232", f"a converter for 5 V, such as a MAX232: {heard}T1IN to {sent}"
    else:
        yield "RS-232", f"too fast for one: a MAX232 follows {FASTEST_RS232} baud"
    if isinstance(interface, ModbusRtu):
        yield "RS-485", "a transceiver, and a pin that switches it: `driver_enable` in the spec"
