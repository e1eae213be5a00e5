"""The registers of a board's serial ports, as C."""

from dataclasses import dataclass

from heatwright.spec.boards import Board

ONE_UART = {"atmega328p"}
"""Chips whose only serial port has a number in the register names, but not in the vectors."""


@dataclass(frozen=True, slots=True)
class UartRegisters:
    """Names of the registers and interrupt vectors of one serial port."""

    number: str
    """The number in register names, such as UDR0."""
    vectors: str
    """First part of the vectors' names: USART0, or USART alone."""
    old: bool = False
    """True if the divisor's high byte shares an address with UCSRC."""

    @property
    def data(self) -> str:
        """The data register."""
        return f"UDR{self.number}"

    @property
    def status(self) -> str:
        """The register with the receiver's flags, which must be read before the data."""
        return f"UCSR{self.number}A"

    @property
    def errors(self) -> str:
        """Error flags: a wrong stop bit, or an overrun."""
        return f"(1u << FE{self.number}) | (1u << DOR{self.number})"

    @property
    def overrun(self) -> str:
        """Overrun flag: at least one byte before this one was lost."""
        return f"(1u << DOR{self.number})"

    @property
    def all_errors(self) -> str:
        """The error flags with that of a wrong parity."""
        return f"{self.errors} | (1u << {'PE' if self.old else 'UPE'}{self.number})"

    def setup(self, divisor: str, *, receives: bool) -> list[str]:
        """Set 8N1 at double speed; enable the transmitter and, if `receives`, the receiver."""
        n = self.number
        enabled = ["TXEN", "RXEN", "RXCIE"] if receives else ["TXEN"]
        bits = " | ".join(f"(1u << {name}{n})" for name in enabled)
        kept = f"UCSR{n}B = (uint8_t)((UCSR{n}B & (1u << UDRIE{n})) | {bits});"
        return [*self.formed(divisor, "8N1"), kept]

    def formed(self, divisor: str, form: str) -> list[str]:
        """Set speed (doubled) and format: 8 bits, no, even or odd parity, 1 or 2 stops: `8E1`.

        The same values written again disturb no byte, except one in UBRRL: it restarts a bit. For
        avr8js one in UCSRA also ends all sending.
        """
        n = self.number
        bits = [f"(1u << UCSZ{n}1)", f"(1u << UCSZ{n}0)"]
        bits += [f"(1u << UPM{n}1)"] if "N" not in form else []
        bits += [f"(1u << UPM{n}0)"] if "O" in form else []
        bits += [f"(1u << USBS{n})"] if form.endswith("2") else []
        return [
            f"UBRR{n}H = (uint8_t)({divisor} >> 8);",
            f"if (UBRR{n}L != (uint8_t){divisor}) {{",
            f"    UBRR{n}L = (uint8_t){divisor}; /* only then: it disturbs a byte on the line */",
            "}",
            f"if ((UCSR{n}A & ((1u << U2X{n}) | (1u << MPCM{n}))) != (1u << U2X{n})) {{",
            f"    UCSR{n}A = (1u << U2X{n});",
            "}",
            f"UCSR{n}C = {self._format}{' | '.join(bits)}; /* {form} */",
        ]

    def enabled(self, *names: str) -> str:
        """Enable the named bits, such as TXEN, and disable all others."""
        bits = " | ".join(f"(1u << {name}{self.number})" for name in names)
        return f"UCSR{self.number}B = {bits};"

    @property
    def _format(self) -> str:
        """On old chips, the bit that selects UCSRC at an address shared with UBRRH; else empty."""
        return "(1u << URSEL) | " if self.old else ""

    @property
    def send_vector(self) -> str:
        """Vector of the interrupt of an empty data register."""
        return f"{self.vectors}_UDRE_vect"

    @property
    def receive_vector(self) -> str:
        """Vector of the interrupt of a received byte."""
        return f"{self.vectors}_RX{'C' if self.old else ''}_vect"

    @property
    def sent_vector(self) -> str:
        """Vector of the interrupt when the last bit has left and no byte waits."""
        return f"{self.vectors}_TX{'C' if self.old else ''}_vect"

    @property
    def interrupt_on(self) -> str:
        """Enable the interrupt of an empty data register."""
        return f"UCSR{self.number}B |= (1u << UDRIE{self.number});"

    @property
    def interrupt_off(self) -> str:
        """Disable the interrupt of an empty data register."""
        return f"UCSR{self.number}B &= (uint8_t)~(1u << UDRIE{self.number});"

    @property
    def interrupt_is_off(self) -> str:
        """Ask whether the interrupt of an empty data register is disabled."""
        return f"(UCSR{self.number}B & (1u << UDRIE{self.number})) == 0"


def registers(board: Board, port: int = 0) -> UartRegisters:
    """Name the registers of one of the board's serial ports."""
    number = board.uarts[port].suffix
    vectors = "USART" if board.mcu in ONE_UART else f"USART{number}"
    return UartRegisters(number, vectors, board.is_old)
