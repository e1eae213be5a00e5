"""The machine that the timing is measured on: readings that keep display and line busy."""

from __future__ import annotations

from heatwright.sim.device import AvrDevice
from heatwright.spec import Controller

SWING_K = 0.1
"""The readings go to and fro by this about a multiple of ten: all digits of them change."""


class Stage:
    """A device whose sensors move to and fro once a period, about where its loops rest.

    The temperatures stay so near to a setpoint that no protection trips.
    """

    def __init__(self, controller: Controller, device: AvrDevice) -> None:
        self._device = device
        self._turns = {
            loop.sensor: (loop.period_s, resting_c(controller, name))
            for name, loop in controller.loops.items()
        }
        self._due_s = dict.fromkeys(self._turns, 0.0)
        self._up = dict.fromkeys(self._turns, False)

    def advance(self, until_s: float) -> None:
        """Run to a time since power-on, s."""
        while (at_s := min(self._due_s.values(), default=until_s)) < until_s:
            self._device.advance(at_s)
            for sensor, due_s in self._due_s.items():
                if due_s <= at_s:
                    self._turn(sensor)
        self._device.advance(until_s)

    def _turn(self, sensor: str) -> None:
        period_s, middle_c = self._turns[sensor]
        self._due_s[sensor] += period_s
        self._up[sensor] = not self._up[sensor]
        self._device.sense(sensor, middle_c + (SWING_K if self._up[sensor] else -SWING_K))


def resting_c(controller: Controller, loop: str) -> float:
    """Return the multiple of ten next to a loop's first setpoint, if that may be set; in °C."""
    setpoint = controller.loops[loop].setpoint
    nearest_c = 10.0 * round(setpoint.initial_c / 10)
    if setpoint.minimum_c <= nearest_c <= setpoint.maximum_c:
        return nearest_c
    return setpoint.initial_c
