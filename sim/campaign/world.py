"""A run of a drawn machine with its binary: scenario, operators, disturbances and faults."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from heatwright.sim.binary.elf import Elf
from heatwright.sim.campaign.breaks import BREAKS
from heatwright.sim.campaign.drawn import Asked, Broken, Drawn, Upsetting
from heatwright.sim.faults.peaks import SPREADING_S
from heatwright.sim.faults.site import LATCHED
from heatwright.sim.faults.world import SPREAD, Site, Weather, World
from heatwright.sim.machine import FEED, TIME, TIPS
from heatwright.sim.plants import plant_of
from heatwright.sim.plants.thermal_network import Plant
from heatwright.sim.scenario import actions, end_s
from heatwright.sim.trace import Series, Trace, TraceEvent
from heatwright.spec.quantity import celsius, duration

Progress = Callable[[float, float], None]

PROGRESS_S = 60.0
"""How often progress is reported, s of simulated time."""


class _Due(NamedTuple):
    """An event and its time; text -- for a plot's legend; disturbs -- it acts on the machine."""

    at_s: float
    act: Callable[[], None]
    text: str | None
    disturbs: bool


class DrawnWorld(World):
    """The world of a drawn machine."""

    def __init__(self, drawn: Drawn, program: Elf, *, logs_nodes: bool = False) -> None:
        """Power the controller on; logs_nodes -- whether every node's temperature is logged."""
        simulation = drawn.controller.simulated
        self._drawn, self._simulation = drawn, simulation
        self.broke_s: float | None = None
        site = Site(drawn.controller, next(iter(drawn.controller.loops)), program)
        weather = Weather(simulation.ambient_c, simulation.ambient_c)
        super().__init__(site, weather, logs_nodes=logs_nodes)

    def _plant(self, weather: Weather) -> Plant:
        """Return the plant with the drawn values, at the spec's start."""
        self._network = self._simulation.plant
        plant = plant_of(
            self._drawn.powered, self._network, ambient_c=weather.ambient_c, step_s=self.step_s,
            seed=self._drawn.noise_seed, errors=self._drawn.errors,
        )  # fmt: skip
        assert isinstance(plant, Plant)  # noqa: S101 - the only kind of plant
        self._began_c = plant.temperatures_c.copy()
        return plant

    # -- a run ---------------------------------------------------------------------------------

    def play(self, progress: Progress) -> None:
        """Run all events, to the end of the scenario.

        If something has broken, the run ends when a fault is latched and the heat has spread.
        """
        ends_s = end_s(self._simulation.scenario)
        for due in sorted(self._due(), key=lambda each: each.at_s):
            if due.at_s < ends_s:
                self._go_to(due.at_s, lambda now_s: progress(now_s, ends_s))
                if not self.is_caught:
                    due.act()
        self._go_to(ends_s, lambda now_s: progress(now_s, ends_s))
        self.step()  # the actions that are due at the end are executed
        if self.is_caught:
            self.until(SPREAD, SPREADING_S)
        self.device.feed()

    @property
    def is_caught(self) -> bool:
        """Whether something has broken, and a fault is latched."""
        return self.broke_s is not None and self.fault != 0

    def _go_to(self, time_s: float, progress: Callable[[float], None]) -> None:
        """Advance to a time, in whole steps, or until a fault of a broken machine is latched."""
        while not self.is_caught and (left := round((time_s - self.now_s) / self.step_s)) > 0:
            piece_s = min(left * self.step_s, max(self.step_s, PROGRESS_S))
            if self.broke_s is None:
                self.run(piece_s)
            else:
                self.until(LATCHED, piece_s)
            progress(self.now_s)

    def _due(self) -> Iterator[_Due]:
        for action in actions(self._simulation.scenario):
            yield _Due(action.time_s, partial(self.do, action), action.text, action.disturbs)
        for ask in self._drawn.asks:
            text = f"{ask.loop} {celsius(ask.setpoint_c)}"
            yield _Due(ask.at_s, partial(self._ask, ask), text, False)
        for upset in self._drawn.upsets:
            yield _Due(upset.at_s, partial(self._upset, upset), _words(upset), True)
        if (fault := self._drawn.fault) is not None:
            yield _Due(fault.at_s, partial(self._break, fault), fault.name, True)

    def _ask(self, ask: Asked) -> None:
        with self.at(ask.loop):
            self.set_setpoint(ask.setpoint_c)

    def _upset(self, upset: Upsetting) -> None:
        if upset.node is None:
            self.power_cut(upset.amount)
        else:
            plant = self._machine.plant
            plant.vector[plant.nodes.index(upset.node)] += upset.amount

    def _break(self, fault: Broken) -> None:
        """Break the drawn part, unless a fault is already latched."""
        if self.fault:
            return
        self.broke_s = self.now_s
        with self.at(fault.loop):
            BREAKS[fault.name][0](self)

    # -- results -------------------------------------------------------------------------------

    def trace(self) -> Trace:
        """Return the run as a bench's trace; nodes' temperatures only if they were logged."""
        machine, rows = self._machine, self._machine.rows
        given, first_s = machine.given(rows), rows[0, TIME]
        nodes_c = machine.nodes_c(rows)
        sensed = rows[:, TIPS : TIPS + len(machine.sensors)]
        tips = {name: _from(sensed[0, i], sensed[:, i]) for i, name in enumerate(machine.sensors)}
        return Trace(
            times_s=_from(first_s, rows[:, TIME] + self.step_s),
            temperatures_c={
                node: _from(self._began_c[i], nodes_c[:, i])
                for i, node in enumerate(machine.plant.nodes if nodes_c.size else ())
            },
            sensed_c={name: tips[name] for name in machine.plant.feelers},
            on_fraction={name: _from(0.0, given[:, i]) for i, name in enumerate(machine.loads)},
            fed_mm_per_s=_from(0.0, rows[:, FEED]),
            currents_a={name: tips[name] for name in machine.plant.ammeters},
            steps={loop: self.device.steps(loop) for loop in self.site.controller.loops},
            events=tuple(
                TraceEvent(due.at_s, due.text, due.disturbs)
                for due in sorted(self._due(), key=lambda each: each.at_s) if due.text
            ),
        )  # fmt: skip


def _words(upset: Upsetting) -> str:
    if upset.node is None:
        return f"power cut {duration(float(f'{upset.amount:.3g}'))}"
    return f"{upset.node} {upset.amount:+.1f} K"


def _from(first: float, rest: Series) -> Series:
    """Return a series with the value before the first step put in front."""
    return np.concatenate(([first], rest))
