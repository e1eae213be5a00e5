"""Inputs of the machine: contacts that are closed to ground while all is well."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated

from pydantic import Field, StrictBool

from heatwright.spec.base import Model, Name, PinName, at_most
from heatwright.spec.quantity import Quantity
from heatwright.spec.units import DURATION

if TYPE_CHECKING:
    from heatwright.spec.controller import Controller

MOST_INPUTS = 8
"""Maximum number of inputs: the tick's interrupt reads each of them."""


class Input(Model):
    """A contact, such as a door's, of an emergency stop or of a thermal cut-out."""

    pin: PinName = Field(description="Pin at the contact to ground; it has a pull-up.")
    trips: StrictBool = Field(
        True,
        description="Rule `input_open`: an open contact is a fault. With `false` the heat only "
        "pauses.",
    )
    for_s: Annotated[float, Quantity(DURATION, least=0.02, most=1.0)] = Field(
        0.05,
        alias="for",
        description="Time that the contact is open until it is a fault, and closed until there may "
        "be heat again.",
    )


Inputs = Annotated[Mapping[Name, Input], at_most(MOST_INPUTS)]


def tripping(controller: Controller) -> dict[str, Input]:
    """List the inputs that are a fault when they open, in the order of the file."""
    return {name: each for name, each in controller.safety.inputs.items() if each.trips}
