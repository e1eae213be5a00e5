"""The level converter between a serial port's pins and the other end of its line."""

from collections.abc import Iterator
from dataclasses import dataclass

from heatwright.generator.plan.pins import label
from heatwright.spec import Board, Controller, ModbusRtu, facts_of
from heatwright.spec.interfaces import Line

FASTEST_RS232 = 120_000
"""Highest baud rate of a MAX232 (data sheet, data rate)."""


@dataclass(frozen=True, slots=True)
class LineRow:
    """A line, a possible other end, and the level converter that this needs."""

    line: str
    to: str
    needs: str


def lines(controller: Controller) -> list[LineRow]:
    """List the level converter for each line, and for each device that may be at its other end."""
    modbus, found = facts_of(controller).modbus, []
    for each in controller.interfaces:
        line, bus = each.line, modbus if each is modbus else None
        if line is None or line.called is None:
            continue
        words = f"{line.called}, {line.told}"
        for to, needs in _converters(controller.board, line, bus):
            found.append(LineRow(words, to, needs))
    return found


def _converters(board: Board, line: Line, bus: ModbusRtu | None) -> Iterator[tuple[str, str]]:
    uart = board.uarts[line.port]
    to, answers = board.pins[uart.tx], line.receives
    sent = label(to)
    received = label(board.pins[uart.rx])
    if bus is not None and bus.driver_enable is not None:
        direction = label(board.pins[bus.driver_enable])
        yield (
            "RS-485",
            f"a transceiver for 5 V, such as a MAX485: RO to {received}, DI to {sent}, DE and /RE "
            f"to {direction}; 120 Ω between A and B at both ends of the bus, bias at one end",
        )
        return
    if to.bootloader:
        yield "USB", "none: the board's USB socket is this line"
    else:
        heard = f"its TXD to {received}, " * answers
        yield "USB", f"an adapter with levels of 5 V: {heard}its RXD to {sent}, ground to ground"
    heard = f"R1OUT to {received}, " * answers
    if line.baud <= FASTEST_RS232:
        yield "RS-232", f"a converter for 5 V, such as a MAX232: {heard}T1IN to {sent}"
    else:
        yield "RS-232", f"too fast for RS-232: a MAX232 reaches {FASTEST_RS232} baud"
    if bus is not None:
        yield "RS-485", "a transceiver, and a pin that switches it: `driver_enable` in the spec"
