"""A text display behind an I²C expander, on any two pins: its keys, and what is known of it."""

import re
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from heatwright.spec.base import Least, Model, PinName, Reference
from heatwright.spec.problems import Checked, Path, refuse, shown

ADDRESSES = (*range(0x20, 0x28), *range(0x38, 0x40))
"""Addresses of a PCF8574, and of a PCF8574A, by its three jumpers."""
SIZES = {"16x2": (16, 2), "20x4": (20, 4)}
"""Columns and rows."""


def _address(value: Any) -> int:
    """Accept an expander's address: 0x27, which heatwright reads as a text, or 39."""
    number = value
    if isinstance(value, str) and re.fullmatch("0x[0-9a-fA-F]{2}", value):
        number = int(value, 16)
    if isinstance(number, bool) or number not in ADDRESSES:
        said = shown(value) if isinstance(value, str) else "this"
        raise refuse(
            f"{said} is no address of a PCF8574",
            "Use 0x20 to 0x27, or 0x38 to 0x3F for a PCF8574A",
        )
    return int(number)


class I2cLcd(Model):
    """A text display (HD44780) behind a PCF8574 expander, on any two pins; it shows a loop."""

    kind: Literal["i2c_lcd"]
    loop: Reference = Field(description="Loop that is shown.")
    sda: PinName = Field(description="Pin at the expander's SDA.")
    scl: PinName = Field(description="Pin at its SCL.")
    size: Literal["16x2", "20x4"] = Field("16x2", description="Columns and rows.")
    address: Annotated[int, Checked(_address, enum=ADDRESSES)] = Field(
        0x27, description="Address that its jumpers set; 0x27 if all are open."
    )
    least: ClassVar[Least] = Least(1400, 65)
    shield: ClassVar[None] = None
    is_host: ClassVar[bool] = False
    acknowledges: ClassVar[bool] = False
    line: ClassVar[None] = None

    @property
    def named_pins(self) -> tuple[tuple[Path, str, str], ...]:
        """The pins of its bus."""
        return (("sda",), self.sda, "the display's SDA"), (("scl",), self.scl, "the display's SCL")

    @property
    def named_loops(self) -> dict[Path, str]:
        """The loop that it shows."""
        return {("loop",): self.loop}

    @property
    def columns(self) -> int:
        """Characters of a row."""
        return SIZES[self.size][0]

    @property
    def rows(self) -> int:
        """Rows of text."""
        return SIZES[self.size][1]
