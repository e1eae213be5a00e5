"""The chips, from their data sheets: memories, timers, and each pin's functions besides I/O."""

from dataclasses import replace

from heatwright.spec.boards.build import FINE_PRESCALERS, SLOW_PRESCALERS, ports
from heatwright.spec.boards.model import Adc, Chip, Timer

_JTAG_ON_C = ("PC2", "PC3", "PC4", "PC5")
_THREE_TIMERS = {
    0: Timer(8, SLOW_PRESCALERS, ("A", "B")),
    1: Timer(16, SLOW_PRESCALERS, ("A", "B")),
    2: Timer(8, FINE_PRESCALERS, ("A", "B")),
}


def _functions(pins: tuple[str, ...], functions: dict[str, str]) -> dict[str, str]:
    return {pin: functions.get(pin, "") for pin in pins}


# Port B6, B7 carry the crystal and C6 the reset: they are no I/O here.
ATMEGA328P = Chip(
    mcu="atmega328p",
    flash_bytes=32768,
    ram_bytes=2048,
    ram_start=0x100,
    eeprom_bytes=1024,
    signature=(0x1E, 0x95, 0x0F),
    fastest_hz=20_000_000,
    adc=Adc(band_gap_code=0x0E, digital_inputs=range(6)),
    timers=_THREE_TIMERS,
    functions=_functions(
        ports({"B": "0-5", "C": "0-5", "D": "0-7"}),
        {
            "PB1": "oc1a",
            "PB2": "oc1b ss",
            "PB3": "oc2a mosi",
            "PB4": "miso",
            "PB5": "sck",
            **{f"PC{bit}": f"adc{bit}" for bit in range(6)},
            "PD0": "rx0",
            "PD1": "tx0",
            "PD3": "oc2b",
            "PD5": "oc0b",
            "PD6": "oc0a",
        },
    ),
)

# PB7 is also OC1C, which is left out: one compare output for each pin is enough.
ATMEGA2560 = Chip(
    mcu="atmega2560",
    flash_bytes=262144,
    ram_bytes=8192,
    ram_start=0x200,
    eeprom_bytes=4096,
    signature=(0x1E, 0x98, 0x01),
    fastest_hz=16_000_000,
    adc=Adc(has_mux5=True),
    jtag_pins=("PF4", "PF5", "PF6", "PF7"),
    timers={
        0: Timer(8, SLOW_PRESCALERS, ("A", "B")),
        1: Timer(16, SLOW_PRESCALERS, ("A", "B", "C")),
        2: Timer(8, FINE_PRESCALERS, ("A", "B")),
        3: Timer(16, SLOW_PRESCALERS, ("A", "B", "C")),
        4: Timer(16, SLOW_PRESCALERS, ("A", "B", "C")),
        5: Timer(16, SLOW_PRESCALERS, ("A", "B", "C")),
    },
    functions=_functions(
        ports(
            {
                **dict.fromkeys("ABCDEF", "0-7"),
                "G": "0-5",
                **dict.fromkeys("HJKL", "0-7"),
            }
        ),
        {
            "PB0": "ss",
            "PB1": "sck",
            "PB2": "mosi",
            "PB3": "miso",
            "PB4": "oc2a",
            "PB5": "oc1a",
            "PB6": "oc1b",
            "PB7": "oc0a",
            "PD2": "rx1",
            "PD3": "tx1",
            "PE0": "rx0",
            "PE1": "tx0",
            "PE3": "oc3a",
            "PE4": "oc3b",
            "PE5": "oc3c",
            **{f"PF{bit}": f"adc{bit}" for bit in range(8)},
            "PG5": "oc0b",
            "PH0": "rx2",
            "PH1": "tx2",
            "PH3": "oc4a",
            "PH4": "oc4b",
            "PH5": "oc4c",
            "PH6": "oc2b",
            "PJ0": "rx3",
            "PJ1": "tx3",
            **{f"PK{bit}": f"adc{bit + 8}" for bit in range(8)},
            "PL3": "oc5a",
            "PL4": "oc5b",
            "PL5": "oc5c",
        },
    ),
)

# Timer 4 has ten bits and a PLL as its clock, unlike the others: it and its OC4x are left out.
ATMEGA32U4 = Chip(
    mcu="atmega32u4",
    flash_bytes=32768,
    ram_bytes=2560,
    ram_start=0x100,
    eeprom_bytes=1024,
    signature=(0x1E, 0x95, 0x87),
    fastest_hz=16_000_000,
    adc=Adc(has_mux5=True),
    timers={
        0: Timer(8, SLOW_PRESCALERS, ("A", "B")),
        1: Timer(16, SLOW_PRESCALERS, ("A", "B", "C")),
        3: Timer(16, SLOW_PRESCALERS, ("A",)),
    },
    functions=_functions(
        ports({"B": "0-7", "C": "6-7", "D": "0-7", "E": "2 6", "F": "0-1 4-7"}),
        {
            "PB0": "ss",
            "PB1": "sck",
            "PB2": "mosi",
            "PB3": "miso",
            "PB4": "adc11",
            "PB5": "oc1a adc12",
            "PB6": "oc1b adc13",
            "PB7": "oc0a",
            "PC6": "oc3a",
            "PD0": "oc0b",
            "PD2": "rx1",
            "PD3": "tx1",
            "PD4": "adc8",
            "PD6": "adc9",
            "PD7": "adc10",
            **{f"PF{bit}": f"adc{bit}" for bit in (0, 1, 4, 5, 6, 7)},
        },
    ),
)

# ATmega16 and 32 differ only in their memories. Timers 0 and 2 have one channel, without a letter.
ATMEGA32 = Chip(
    mcu="atmega32",
    flash_bytes=32768,
    ram_bytes=2048,
    ram_start=0x60,
    eeprom_bytes=1024,
    signature=(0x1E, 0x95, 0x02),
    fastest_hz=16_000_000,
    adc=Adc(band_gap_v=1.22),
    jtag_pins=_JTAG_ON_C,
    is_old=True,
    timers={
        0: Timer(8, SLOW_PRESCALERS, ("",)),
        1: Timer(16, SLOW_PRESCALERS, ("A", "B")),
        2: Timer(8, FINE_PRESCALERS, ("",)),
    },
    functions=_functions(
        ports(dict.fromkeys("ABCD", "0-7")),
        {
            **{f"PA{bit}": f"adc{bit}" for bit in range(8)},
            "PB3": "oc0",
            "PB4": "ss",
            "PB5": "mosi",
            "PB6": "miso",
            "PB7": "sck",
            "PD0": "rx",
            "PD1": "tx",
            "PD4": "oc1b",
            "PD5": "oc1a",
            "PD7": "oc2",
        },
    ),
    longest_watchdog_s=2.0,
)
ATMEGA16 = replace(
    ATMEGA32,
    mcu="atmega16",
    flash_bytes=16384,
    ram_bytes=1024,
    eeprom_bytes=512,
    signature=(0x1E, 0x94, 0x03),
)

# The ATmega644P and 1284P differ in their memories, and the smaller one has no timer 3.
ATMEGA644P = Chip(
    mcu="atmega644p",
    flash_bytes=65536,
    ram_bytes=4096,
    ram_start=0x100,
    eeprom_bytes=2048,
    signature=(0x1E, 0x96, 0x0A),
    fastest_hz=20_000_000,
    adc=Adc(digital_inputs=range(8)),
    jtag_pins=_JTAG_ON_C,
    timers=_THREE_TIMERS,
    functions=_functions(
        ports(dict.fromkeys("ABCD", "0-7")),
        {
            **{f"PA{bit}": f"adc{bit}" for bit in range(8)},
            "PB3": "oc0a",
            "PB4": "oc0b ss",
            "PB5": "mosi",
            "PB6": "miso",
            "PB7": "sck",
            "PD0": "rx0",
            "PD1": "tx0",
            "PD2": "rx1",
            "PD3": "tx1",
            "PD4": "oc1b",
            "PD5": "oc1a",
            "PD6": "oc2b",
            "PD7": "oc2a",
        },
    ),
)
ATMEGA1284P = replace(
    ATMEGA644P,
    mcu="atmega1284p",
    flash_bytes=131072,
    ram_bytes=16384,
    eeprom_bytes=4096,
    signature=(0x1E, 0x97, 0x05),
    timers=_THREE_TIMERS | {3: Timer(16, SLOW_PRESCALERS, ("A", "B"))},
    functions={**ATMEGA644P.functions, "PB6": "oc3a miso", "PB7": "oc3b sck"},
)
