"""The spec's machine, which runs until the bench is closed."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heatwright.cli.bench.breakage import Breakage
from heatwright.sim.binary.elf import Elf
from heatwright.sim.faults.world import Site, Weather, World
from heatwright.sim.machine import TIME
from heatwright.sim.plants import plant_of
from heatwright.sim.plants.thermal_network import Plant
from heatwright.spec import Controller

LEAST_SUPPLY, MOST_SUPPLY = 0.0, 1.3
"""Range of the heaters' supply voltage, as a factor of the nominal one."""


class Course(NamedTuple):
    """Values of a loop's control steps; machine_c -- the temperature of the sensor's node."""

    time_s: NDArray[np.float64]
    temperature_c: NDArray[np.float64]
    machine_c: NDArray[np.float64]
    setpoint_c: NDArray[np.float64]
    duty_percent: NDArray[np.float64]


class LiveWorld(World):
    """A world that runs until it is closed: `take_courses` and `forget` delete its records.

    breakage -- the faults that the user has caused.
    """

    def __init__(self, controller: Controller, program: Path | Elf) -> None:
        """Power the controller on; the spec must have a simulation."""
        simulation = self._simulation = controller.simulated
        elf = program if isinstance(program, Elf) else Elf(program)
        site = Site(controller, next(iter(controller.loops)), elf)
        weather = Weather(simulation.ambient_c, simulation.ambient_c)
        super().__init__(site, weather, logs_nodes=True)
        self.peaks.end()
        self.breakage = Breakage(self, elf)

    def _plant(self, weather: Weather) -> Plant:
        """Return the spec's plant at its start."""
        self._network = self._simulation.plant
        plant = plant_of(
            self.site.controller, self._network, ambient_c=weather.ambient_c, step_s=self.step_s
        )
        assert isinstance(plant, Plant)  # noqa: S101 - the only kind of plant
        return plant

    # -- the surroundings ----------------------------------------------------------------------

    def set_ambient(self, ambient_c: float) -> None:
        """Move the machine to other surroundings, °C."""
        self.ambient_c = self._machine.plant.vector[-1] = ambient_c

    def take_heat(self, output: str, watts: float) -> None:
        """Remove this heat flow at a heater's node from now on, W."""
        power_w = dict(self._machine.plant.heaters_w)[output]
        self.wiring.taken[output] = watts / power_w

    @property
    def taken_w(self) -> dict[str, float]:
        """Removed heat flow of each heater, W."""
        taken = self.wiring.taken
        return {name: taken.get(name, 0.0) * power_w for name, power_w in self.heaters_w}

    @property
    def heaters_w(self) -> tuple[tuple[str, float], ...]:
        """Each heater with its power while it is on, W."""
        return self._machine.plant.heaters_w

    @property
    def nodes_c(self) -> dict[str, float]:
        """The temperature of every node now, °C."""
        plant = self._machine.plant
        return dict(zip(plant.nodes, plant.temperatures_c.tolist(), strict=True))

    def power_cut(self, off_s: float = 1.0, *, undefined: int = 0xFF) -> None:
        """Cut the power; active faults stay."""
        super().power_cut(off_s, undefined=undefined)
        self.breakage.renew()

    # -- the records ---------------------------------------------------------------------------

    def take_courses(self) -> dict[str, Course]:
        """Return the values of each loop since the last call, and drop them."""
        machine, loops = self._machine, self.site.controller.loops
        rows = machine.take_rows()
        nodes_c = machine.nodes_c(rows)
        found = {}
        for name, loop in loops.items():
            log = self.device.take_steps(name)
            node = self._network.sense[loop.sensor].node
            number = machine.plant.nodes.index(str(node))
            now_c = machine.plant.temperatures_c[number]
            here_c = nodes_c[:, number] if len(rows) else np.array([now_c])
            at = np.searchsorted(rows[:, TIME], log["time_s"], side="right") - 1
            found[name] = Course(
                log["time_s"],
                log["temperature_c"].astype(float),
                here_c[at.clip(0)],
                log["setpoint_c"].astype(float),
                log["duty_percent"].astype(float),
            )
        return found

    def forget(self) -> None:
        """Drop records that nothing needs any more."""
        self.device.take_resets()
        self.trips.forget()
