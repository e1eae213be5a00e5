"""A newsensor: the conversion of its raw readings, from the data sheet, never from the driver."""

from collections.abc import Callable

from heatwright.sim.reference.numbers import Single
from heatwright.spec import Board
from heatwright_newsensor.model import Newsensor


def converter(sensor: Newsensor, board: Board) -> Callable[[int], Single]:
    """Return the conversion of a raw reading to °C, in the firmware's single precision."""
    raise NotImplementedError


class IdealSensor:
    """A sensor without any fault."""

    def __init__(self, sensor: Newsensor, board: Board) -> None:
        """Set `sampled_before_step_s`, the age of a reading at its control step, s."""
        self.sampled_before_step_s = sensor.conversion_s

    def read(self, temperature_c: float) -> tuple[int, int]:
        """Return the reading's status, 0 if it is valid, and the raw reading."""
        raise NotImplementedError
