"""Transfer a device's outputs to its machine: heat, moving air, fed material."""

from collections.abc import Iterable, Mapping, Set
from typing import Protocol

from heatwright.spec import Controller, facts_of
from heatwright.spec.loops import shortest_period_s

METERED_PARTS = 10
"""Minimum number of time steps in a control period if a current is measured: a limiter must read
the current of the present duty."""


class Driver(Protocol):
    """The outputs of a device."""

    def on_fraction(self, output: str) -> float:
        """Return the mean active fraction (0..1) of an output since the last call."""

    def travel_mm(self, output: str) -> float:
        """Return a stepper's feed since the last call, mm."""

    def relay_fraction(self) -> float:
        """Return the share of time (0..1) the safety relay has conducted since the last call."""


def sums_noise(controller: Controller, sensor: str) -> bool:
    """Return whether the ADC sums up readings of a sensor that has simulated noise."""
    if controller.simulation is None or getattr(controller.sensors[sensor], "oversample", 1) == 1:
        return False
    sense = controller.simulation.plant.sense.get(sensor)
    return sense is not None and sense.noise_k > 0


def metered_step_s(controller: Controller) -> float:
    """Return the longest time step with which a current sensor follows its current soon enough, s.

    The sensor shows the mean over the step before. Infinite if no current is measured.
    """
    metered = (
        loop for name, loop in controller.loops.items() if facts_of(controller, name).current
    )
    return shortest_period_s(metered) / METERED_PARTS


class Coupling:
    """Reads a device's outputs once in each time step of the machine."""

    def __init__(
        self,
        controller: Controller,
        device: Driver,
        step_s: float,
        loads: Iterable[str] | None = None,
    ) -> None:
        """Separate motors from loads; loads -- the loads that are read, None: all."""
        self._steppers = tuple(controller.steppers)
        self.loads = tuple(controller.switches if loads is None else loads)
        heaters = {loop.heater for loop in controller.loops.values()}
        self.behind_relay: Set[str] = heaters if controller.safety.relay else frozenset()
        self._device = device
        self._step_s = step_s
        self.extruded_mm_per_s = 0.0
        """Material fed from outside, beside the device's own motors, mm/s."""

    @property
    def moves(self) -> bool:
        """Whether the device has motors."""
        return bool(self._steppers)

    def active(self) -> Mapping[str, float]:
        """Return the mean active fraction of each load since the last call, 0..1."""
        return {name: self._device.on_fraction(name) for name in self.loads}

    def supplied(self, conducting: Mapping[str, float]) -> Mapping[str, float]:
        """Return the loads' shares of power, given their switches' shares, behind the safety relay.

        Relay and switch are in series, and the relay switches without load: so the smaller of their
        shares is used. A switch that has failed closed conducts all the time.
        """
        if not self.behind_relay:
            return conducting
        closed = self._device.relay_fraction()
        return {
            name: min(share, closed) if name in self.behind_relay else share
            for name, share in conducting.items()
        }

    def feed_mm_per_s(self) -> float:
        """Return the mean feed speed since the last call; retracted material takes no heat."""
        if not self._steppers:
            return self.extruded_mm_per_s
        travel_mm = sum(self._device.travel_mm(name) for name in self._steppers)
        return max(0.0, self.extruded_mm_per_s + travel_mm / self._step_s)
