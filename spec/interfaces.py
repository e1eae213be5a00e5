"""Interfaces: how an operator or a computer sees and sets the loops."""

from typing import Annotated, Any, Literal

from pydantic import Field

from heatwright.spec.base import Model, Reference
from heatwright.spec.problems import Checked, refuse
from heatwright.spec.quantity import Quantity
from heatwright.spec.units import DIFFERENCE


def _baud(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise refuse("a baud rate is a whole number", "Write it without a unit, such as 9600")
    if not 300 <= value <= 2_000_000:
        raise refuse(f"{value} is no usable baud rate", "Use 300 to 2000000, such as 9600")
    return value


class LcdKeypad(Model):
    """The Arduino LCD keypad shield: 16x2 characters, five keys on A0."""

    kind: Literal["lcd_keypad"]
    loop: Reference = Field(description="Loop that is shown and set.")
    step_k: Annotated[float, Quantity(DIFFERENCE, least=0.1, most=100.0)] = Field(
        1.0, alias="step", description="Change of the setpoint for each press of UP or DOWN."
    )


class SerialPlotter(Model):
    """One line of numbers each period for the program Serial Port Plotter."""

    kind: Literal["serial_plotter"]
    loop: Reference = Field(description="Loop whose numbers are sent.")
    baud: Annotated[int, Checked(_baud, type="integer", minimum=300, maximum=2_000_000)] = Field(
        9600, description="Speed of the line."
    )


Interface = Annotated[LcdKeypad | SerialPlotter, Field(discriminator="kind")]
