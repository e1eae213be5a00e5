"""The chips, from their data sheets: memories, timers, and each pin's functions besides I/O."""

from dataclasses import replace

from heatwright.spec.boards.build import FINE_PRESCALERS, SLOW_PRESCALERS
from heatwright.spec.boards.model import Adc, Chip, Timer

_JTAG_ON_C = ("PC2", "PC3", "PC4", "PC5")
_THREE_TIMERS = {
    0: Timer(8, SLOW_PRESCALERS, ("A", "B")),
    1: Timer(16, SLOW_PRESCALERS, ("A", "B")),
    2: Timer(8, FINE_PRESCALERS, ("A", "B")),
}


def _functions(**ports: str) -> dict[str, str]:
    """Return the functions of each pin, from words for the pins of each port, bit 0 first.

    `-` is a pin without another function, `x` is no pin; a comma separates two functions of a pin.
    """
    return {
        f"P{port}{bit}": word.strip("-").replace(",", " ")
        for port, words in ports.items()
        for bit, word in enumerate(words.split())
        if word != "x"
    }


# PB6 and PB7 are at the crystal and PC6 is the reset: they are no I/O here.
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
        B="- oc1a oc1b,ss oc2a,mosi miso sck",
        C="adc0 adc1 adc2 adc3 adc4 adc5",
        D="rx0 tx0 - oc2b - oc0b oc0a -",
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
        A="- - - - - - - -",
        B="ss sck mosi miso oc2a oc1a oc1b oc0a",
        C="- - - - - - - -",
        D="- - rx1 tx1 - - - -",
        E="rx0 tx0 - oc3a oc3b oc3c - -",
        F="adc0 adc1 adc2 adc3 adc4 adc5 adc6 adc7",
        G="- - - - - oc0b",
        H="rx2 tx2 - oc4a oc4b oc4c oc2b -",
        J="rx3 tx3 - - - - - -",
        K="adc8 adc9 adc10 adc11 adc12 adc13 adc14 adc15",
        L="- - - oc5a oc5b oc5c - -",
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
        B="ss sck mosi miso adc11 oc1a,adc12 oc1b,adc13 oc0a",
        C="x x x x x x oc3a -",
        D="oc0b - rx1 tx1 adc8 - adc9 adc10",
        E="x x - x x x -",
        F="adc0 adc1 x x adc4 adc5 adc6 adc7",
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
        A="adc0 adc1 adc2 adc3 adc4 adc5 adc6 adc7",
        B="- - - oc0 ss mosi miso sck",
        C="- - - - - - - -",
        D="rx tx - - oc1b oc1a - oc2",
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
        A="adc0 adc1 adc2 adc3 adc4 adc5 adc6 adc7",
        B="- - - oc0a oc0b,ss mosi miso sck",
        C="- - - - - - - -",
        D="rx0 tx0 rx1 tx1 oc1b oc1a oc2b oc2a",
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
