"""The parts of a board: its chip, its pins by name, its timers and serial ports."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple


class Pin(NamedTuple):
    """One pin of the chip, under the name the board gives it."""

    name: str
    """The board's own name, such as `D3`; its port's name, `PD3`, on a bare chip."""
    port: str
    bit: int
    adc: int | None = None
    pwm: tuple[int, str] | None = None
    """Timer and channel of the compare output; the channel is "" where the timer has one only."""
    serial: str | None = None
    """Line of a serial port that the pin can be: `rx` or `tx`."""
    spi: str | None = None
    """Line of the SPI bus that the pin can be: `ss`, `sck`, `mosi` or `miso`."""
    led: bool = False
    bootloader: bool = False
    """True if the bootloader drives the pin, or pulls it up, at every reset."""

    @property
    def digital(self) -> bool:
        """False for the pins that lead to the ADC alone (A6 and A7 of a Nano)."""
        return self.port != ""

    @property
    def port_name(self) -> str:
        """The chip's own name of the pin, such as `PD3`."""
        return f"P{self.port}{self.bit}"

    @property
    def label(self) -> str:
        """Both names for messages, such as `D3 (PD3)`; only one if the pin has no other."""
        if not self.digital or self.name == self.port_name:
            return self.name
        return f"{self.name} ({self.port_name})"


class Timer(NamedTuple):
    """One timer/counter; prescalers in the order of its clock-select codes, from 1."""

    bits: Literal[8, 16]
    prescalers: tuple[int, ...]
    channels: tuple[str, ...]


class Uart(NamedTuple):
    """One serial port; `suffix` ends its registers' names: UDR0, but UDR on the oldest chips."""

    suffix: str
    rx: str
    tx: str

    @property
    def number(self) -> int:
        """Number of the port; 0 where it is the only one and its registers have none."""
        return int(self.suffix or 0)


class Adc(NamedTuple):
    """Properties of the ADC that differ between chips."""

    band_gap_code: int = 0x1E
    """Code in ADMUX that selects the band gap voltage."""
    band_gap_v: float = 1.1
    """Typical band gap voltage; ±10 %."""
    has_mux5: bool = False
    digital_inputs: range = range(16)
    """Channels whose pin has a digital input that can be switched off: DIDR0, DIDR2."""


@dataclass(frozen=True, kw_only=True)
class Chip:
    """One microcontroller, from its data sheet."""

    mcu: str
    flash_bytes: int
    ram_bytes: int
    ram_start: int
    eeprom_bytes: int
    signature: tuple[int, int, int]
    fastest_hz: int
    """Highest clock at 5 V."""
    timers: Mapping[int, Timer]
    functions: Mapping[str, str]
    """Functions of a pin by its port's name: "adc0 oc1a sck rx0", in any order."""
    adc: Adc = field(default_factory=Adc)
    jtag_pins: tuple[str, ...] = ()
    """Pins of the JTAG port, which a fuse enables in chips as delivered. Boards with a bootloader
    have it disabled."""
    longest_watchdog_s: float = 8.0
    is_old: bool = False
    """The chip is of the older generation. Its timers share TIMSK and TIFR, an 8-bit timer has one
    control register (TCCR0) and one compare channel without letter (OCR0), UCSRC and UBRRH share
    an address, and there is no DIDR ("Register Summary")."""


@dataclass(frozen=True)
class Layout:
    """The pins of a board and its other properties besides the chip's."""

    platformio: str
    """The board's id in PlatformIO."""
    names: Mapping[str, str] = field(default_factory=dict)
    """The port's name of each pin by its printed name; empty for a bare chip."""
    bootloader_bytes: int = 0
    bootloader_pins: str = ""
    led: str = ""
    analog_only: Mapping[str, int] = field(default_factory=dict)
    """The ADC's channel of each pin that leads to the ADC alone, by its printed name."""
    clock_hz: int = 16_000_000
    shield: bool = False
    """True if an Arduino Uno's shields fit: D0 to D13 and A0 to A5 are where an Uno has them."""
    bootloader_talks: tuple[str, int] | None = None
    """Protocol of its bootloader, as avrdude calls it, and baud; None on a bare chip."""
    bears_watchdog: bool = True
    """False if the bootloader leaves the watchdog on after a watchdog reset, so that the watchdog
    resets the chip again and again."""


@dataclass(frozen=True, kw_only=True)
class Board(Layout, Chip):
    """A chip on a board (or bare), with its clock and the names of its pins."""

    name: str
    pins: Mapping[str, Pin]
    """Pins by all of their names: `D3` and `PD3` give the same Pin."""
    uarts: tuple[Uart, ...]

    @property
    def macro(self) -> str:
        """Name of the macro that avr-gcc defines for the chip."""
        return f"__AVR_ATmega{self.mcu.removeprefix('atmega').upper()}__"
