"""What stops all heat from outside the loops: monitors and inputs.

Monitors are sensors that warn at one temperature and stop at another; inputs are contacts that are
closed to ground while all is well.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated

from pydantic import Field, StrictBool

from heatwright.spec.base import Model, Name, PinName, Reference, Temperature, at_most
from heatwright.spec.quantity import Quantity
from heatwright.spec.sensors import shortest_period_s
from heatwright.spec.units import DIFFERENCE, DURATION

if TYPE_CHECKING:
    from heatwright.spec.controller import Controller


MOST_MONITORS = 8
"""Maximum number of monitors: each takes an address and a bit of its own on a Modbus line."""


class Monitor(Model):
    """A sensor that belongs to no loop, with a warning and a limit."""

    sensor: Reference = Field(description="The monitor's sensor; no loop uses it as `sensor`.")
    warning_c: Temperature = Field(
        alias="warning", description="Temperature that warns people; nothing else happens."
    )
    limit_c: Temperature = Field(
        alias="limit", description="Rule `monitor_limit`: temperature that stops all heaters."
    )
    hysteresis_k: Annotated[float, Quantity(DIFFERENCE, least=0.001)] = Field(
        2.0, alias="hysteresis", description="The warning ends this far below `warning`."
    )
    stale_after_s: Annotated[float, Quantity(DURATION, least=0.01)] = Field(
        5.0, alias="stale_after", description="Time without a valid reading until a fault."
    )


Monitors = Annotated[Mapping[Name, Monitor], at_most(MOST_MONITORS)]


def watching_loop(controller: Controller, name: str) -> str | None:
    """Name the loop whose control step checks a monitor; None where there is none.

    It is the loop that names it in `also`, or the first whose period is long enough for a reading.
    """
    sensor = controller.thermometers.get(controller.monitors[name].sensor)
    if sensor is None:
        return None
    needed_s = shortest_period_s(sensor)
    loops = {loop: each for loop, each in controller.loops.items() if each.also == name}
    return next(
        (loop for loop, each in (loops or controller.loops).items() if each.has_time_for(needed_s)),
        None,
    )


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
