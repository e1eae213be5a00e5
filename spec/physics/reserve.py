"""The reserve of a heater: its power compared with the need at the highest setpoint."""

from collections.abc import Iterator
from typing import NamedTuple

from heatwright.spec.checks.finding import Finding, loop_heaters
from heatwright.spec.checks.physics.machine import Machine
from heatwright.spec.controller import Controller
from heatwright.spec.quantity import about, celsius, number

RECOMMENDED = (0.3, 0.5)
"""Recommended reserve, as a share of the needed power: for a weak supply, cold and draught."""


class Reserve(NamedTuple):
    """One loop's heater against its machine's losses, while the others are off."""

    loop: str
    heater: str
    power_w: float
    """Power of the heater at full duty, or as much as its limits allow."""
    needed_w: float
    """Power that holds the highest setpoint."""
    setpoint_c: float
    ambient_c: float

    @property
    def share(self) -> float:
        """The reserve, as a share of the needed power."""
        return self.power_w / self.needed_w - 1

    @property
    def resistance_k_per_w(self) -> float:
        """Thermal resistance from the sensor to ambient at the highest setpoint, K/W."""
        return (self.setpoint_c - self.ambient_c) / self.needed_w

    @property
    def recommended_w(self) -> tuple[float, float]:
        """Smallest and largest power that is recommended, W."""
        low, high = (self.needed_w * (1 + share) for share in RECOMMENDED)
        return low, high

    def __str__(self) -> str:
        return (
            f"{self.loop}: {about(self.power_w)} W, a reserve of {number(round(100 * self.share))} "
            f"% over the {about(self.needed_w)} W that {celsius(self.setpoint_c)} needs at an "
            f"ambient of {celsius(self.ambient_c)}"
        )


def reserves(controller: Controller) -> Iterator[Reserve]:
    """Yield the reserve of each loop of a checked spec that must heat to its highest setpoint."""
    simulation = controller.simulation
    if simulation is None:
        return
    for name, loop, heater in loop_heaters(controller):
        machine = Machine(controller, name, heater, simulation)
        needed_w = machine.plant.power_w(machine.target_k)
        if machine.target_k > 0 and needed_w > 0:
            yield Reserve(
                name, loop.heater, machine.full_power_w, needed_w,
                loop.setpoint.maximum_c, machine.ambient_c,
            )  # fmt: skip


def small_reserves(controller: Controller) -> Iterator[Finding]:
    """Find reserves below the recommended ones: not an error, but the machine may stay too cold."""
    for reserve in reserves(controller):
        if reserve.share >= RECOMMENDED[0]:
            continue
        low_w, high_w = map(about, reserve.recommended_w)
        yield Finding(
            ("outputs", reserve.heater, "power"),
            f"the reserve is {number(round(100 * reserve.share))} %: full duty gives "
            f"{about(reserve.power_w)} W, and the highest setpoint of "
            f"{celsius(reserve.setpoint_c)} needs {about(reserve.needed_w)} W. With a low supply, "
            "a colder room or a draught the machine may not reach it",
            f"Use a heater of {low_w} to {high_w} W (a reserve of 30 to 50 %), or lower the "
            "highest setpoint",
        )
