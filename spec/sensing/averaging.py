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


class Started(Averaged):
    """A thermometer whose conversions the firmware starts, by a command or by reading it."""

    @property
    def free_running_s(self) -> float:
        """Interval of conversions that the sensor starts by itself: 0, it starts none."""
        return 0.0

    @property
    def first_s(self) -> float:
        """Time that the sensor needs after the power-up, s: 0, it is ready in the first period."""
        return 0.0
