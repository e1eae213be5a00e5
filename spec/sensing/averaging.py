"""The mean of the last readings, which all thermometers can have for the control."""

from typing import Annotated

from pydantic import Field

from heatwright.spec.base import Model, WholeNumber


class Averaged(Model):
    """A thermometer, whose readings may be averaged for the control."""

    kind: str
    moving_average: Annotated[int, WholeNumber("a number of readings", 1, 16, 5)] = Field(
        1,
        description="Readings, one each control step, whose mean the control uses; the "
        "protections use every single reading.",
    )
