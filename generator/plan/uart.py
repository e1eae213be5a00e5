"""The registers of a board's first serial port, as C."""

from __future__ import annotations

from dataclasses import dataclass

from heatwright.generator.plan.chips import is_old
from heatwright.spec.boards import Board

ONE_UART = {"atmega328p"}
"""Chips whose only serial port has a number in its registers, but none in its vectors."""


@dataclass(frozen=True, slots=True)
class UartRegisters:
    """Names of registers and vectors."""

    number: str
    """What they carry: UDR0."""
    vectors: str
    """What its vectors begin with: USART0, or USART alone."""
    old: bool = False
    """The divisor has no 16-bit name, and its high byte shares an address with the format."""

    @property
    def data(self) -> str:
        """The data register."""
        return f"UDR{self.number}"

    @property
    def status(self) -> str:
        """The register with the receiver's flags, to be read before the data."""
        return f"UCSR{self.number}A"

    @property
    def errors(self) -> str:
        """Flags of a byte that was damaged (its stop bit) or follows one that was lost."""
        return f"(1u << FE{self.number}) | (1u << DOR{self.number})"

    def setup(self, divisor: str, *, receives: bool) -> list[str]:
        """Set 8N1 at double speed; the transmitter, and perhaps the receiver's interrupt, on."""
        n = self.number
        enabled = ["TXEN", "RXEN", "RXCIE"] if receives else ["TXEN"]
        bits = " | ".join(f"(1u << {bit}{n})" for bit in enabled)
        return [
            *self._divided_by(divisor),
            f"UCSR{n}A = (1u << U2X{n});",
            f"UCSR{n}C = {self._format}(1u << UCSZ{n}1) | (1u << UCSZ{n}0); /* 8N1 */",
            f"UCSR{n}B = {bits};",
        ]

    def _divided_by(self, divisor: str) -> list[str]:
        if not self.old:
            return [f"UBRR{self.number} = {divisor};"]
        return [f"UBRRH = (uint8_t)({divisor} >> 8);", f"UBRRL = (uint8_t){divisor};"]

    @property
    def _format(self) -> str:
        """What tells the format from the divisor's high byte, to be put before other bits."""
        return "(1u << URSEL) | " if self.old else ""

    @property
    def send_vector(self) -> str:
        """Interrupt of an empty data register."""
        return f"{self.vectors}_UDRE_vect"

    @property
    def receive_vector(self) -> str:
        """Interrupt of a byte received."""
        return f"{self.vectors}_RX{'C' if self.old else ''}_vect"

    @property
    def interrupt_on(self) -> str:
        """Ask for the interrupt of an empty data register."""
        return f"UCSR{self.number}B |= (1u << UDRIE{self.number});"

    @property
    def interrupt_off(self) -> str:
        """Ask for it no longer."""
        return f"UCSR{self.number}B &= (uint8_t)~(1u << UDRIE{self.number});"


def registers(board: Board) -> UartRegisters:
    """Name the registers of the board's first serial port."""
    number = board.uarts[0].suffix
    vectors = "USART" if board.mcu in ONE_UART else f"USART{number}"
    return UartRegisters(number, vectors, is_old(board))
