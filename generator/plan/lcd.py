"""The screen of the LCD keypad shield: it shows text (lcd.h), without its keys."""

from dataclasses import dataclass

from heatwright.generator.plan.numbers import ticks
from heatwright.generator.plan.parts import Call, Constant, Part, Stage, Wiring, pair
from heatwright.generator.plan.pins import driven
from heatwright.generator.plan.source import Source

LINES = (("rs", "D8"), ("e", "D9"), ("d4", "D4"), ("d5", "D5"), ("d6", "D6"), ("d7", "D7"))
"""The shield's wiring. D10 is not used: a resistor keeps the backlight on."""

POWER_UP_S = 0.05
"""Wait before the first instruction: 40 ms after 2.7 V (HD44780U data sheet, figure 24)."""
RESYNC_S = 30.0

CONSTANTS = (
    Constant("LCD_POWER_UP_TICKS", f"{ticks(POWER_UP_S)}u", "50 ms; the data sheet requires 40 ms"),
    Constant(
        "LCD_RESYNC_TICKS", f"{ticks(RESYNC_S)}u", f"{RESYNC_S:g} s between start-up sequences"
    ),
)
"""Constants of config.h."""


DATA_LINES = (("d4", 0x10), ("d5", 0x20), ("d6", 0x40), ("d7", 0x80))
"""The four data lines, each with its bit in a byte's upper half."""


@dataclass(frozen=True, slots=True)
class LcdNames:
    """The values for the template of the screen."""

    where: str
    resync_s: str
    data_lines: tuple[tuple[str, int], ...]


def plan(source: Source) -> Part:
    """Plan the screen."""
    pins = source.controller.board.pins
    lcd = LcdNames(source.where, f"{RESYNC_S:g}", DATA_LINES)
    return Part(
        files=pair("lcd", "interfaces/lcd/lcd", lcd, plain_header=True),
        pins=tuple(
            driven(source, f"lcd_{name}", pins[pin], f"{name.upper()} of the display")
            for name, pin in LINES
        ),
        start_calls=(Call(Stage.SHOW, "lcd.h", "lcd_start();"),),
        tick_calls=(Call(Stage.SHOW, "lcd.h", "lcd_tick();"),),
        wiring=(
            Wiring(
                " ".join(sorted(pin for _, pin in LINES)),
                "LCD keypad shield, display",
                "D4..D7 data, D8 RS, D9 E, R/W to ground",
                end="data, RS, E",
            ),
        ),
    )
