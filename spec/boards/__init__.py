"""The boards that a spec can name."""

from heatwright.spec.boards import chips
from heatwright.spec.boards.build import build
from heatwright.spec.boards.model import Board, Layout, Pin, Timer, Uart
from heatwright.spec.registry import usable


def _numbered(prefix: str, first: int, port_names: str) -> dict[str, str]:
    names = port_names.split()
    return {f"{prefix}{first + offset}": name for offset, name in enumerate(names)}


_UNO_PINS = _numbered(
    "D", 0, "PD0 PD1 PD2 PD3 PD4 PD5 PD6 PD7 PB0 PB1 PB2 PB3 PB4 PB5"
) | _numbered("A", 0, "PC0 PC1 PC2 PC3 PC4 PC5")

_MEGA_PINS = (
    _numbered("D", 0, "PE0 PE1 PE4 PE5 PG5 PE3 PH3 PH4 PH5 PH6 PB4 PB5 PB6 PB7")
    | _numbered("D", 14, "PJ1 PJ0 PH1 PH0 PD3 PD2 PD1 PD0")
    | _numbered("D", 22, "PA0 PA1 PA2 PA3 PA4 PA5 PA6 PA7 PC7 PC6 PC5 PC4 PC3 PC2 PC1 PC0")
    | _numbered("D", 38, "PD7 PG2 PG1 PG0 PL7 PL6 PL5 PL4 PL3 PL2 PL1 PL0 PB3 PB2 PB1 PB0")
    | _numbered("A", 0, "PF0 PF1 PF2 PF3 PF4 PF5 PF6 PF7 PK0 PK1 PK2 PK3 PK4 PK5 PK6 PK7")
)

# D14 to D16 are on the ISP header alone; D17 is the receive LED.
_LEONARDO_PINS = _numbered(
    "D", 0, "PD2 PD3 PD1 PD0 PD4 PC6 PD7 PE6 PB4 PB5 PB6 PB7 PD6 PC7 PB3 PB1 PB2 PB0"
) | _numbered("A", 0, "PF7 PF6 PF5 PF4 PF1 PF0")

# Optiboot and older bootloaders flash the LED and use the serial port at every reset.
_SERIAL_BOOTLOADER = "D0 D1 D13"

_LAYOUTS = {
    "uno": (
        chips.ATMEGA328P,
        Layout(
            "uno",
            _UNO_PINS,
            512,
            _SERIAL_BOOTLOADER,
            led="D13",
            shield=True,
            bootloader_talks=("arduino", 115_200),
        ),
    ),
    "nano": (
        chips.ATMEGA328P,
        # most Nanos are sold with this older bootloader
        Layout(
            "nanoatmega328",
            _UNO_PINS,
            2048,
            _SERIAL_BOOTLOADER,
            "D13",
            {"A6": 6, "A7": 7},
            bootloader_talks=("arduino", 57_600),
            bears_watchdog=False,
        ),
    ),
    "mega2560": (
        chips.ATMEGA2560,
        Layout(
            "megaatmega2560",
            _MEGA_PINS,
            8192,
            _SERIAL_BOOTLOADER,
            led="D13",
            shield=True,
            bootloader_talks=("wiring", 115_200),
        ),
    ),
    "leonardo": (
        chips.ATMEGA32U4,
        # the bootloader drives these two LEDs; a third one, on PD5, has no pin
        Layout(
            "leonardo",
            _LEONARDO_PINS,
            4096,
            "D13 D17",
            led="D13",
            shield=True,
            bootloader_talks=("avr109", 57_600),
        ),
    ),
    "atmega328p": (chips.ATMEGA328P, Layout("ATmega328P")),
    "atmega2560": (chips.ATMEGA2560, Layout("ATmega2560")),
    "atmega32": (chips.ATMEGA32, Layout("ATmega32")),
    "atmega16": (chips.ATMEGA16, Layout("ATmega16")),
    "atmega644p": (chips.ATMEGA644P, Layout("ATmega644P")),
    "atmega1284p": (chips.ATMEGA1284P, Layout("ATmega1284P")),
}

BOARDS: dict[str, Board] = {
    name: build(name, *parts) for name, parts in (usable("board") | _LAYOUTS).items()
}
