"""The test bench: a device wired to a simulated machine and an operator."""

from collections.abc import Callable, Iterable, Mapping
from typing import Protocol

import numpy as np

from heatwright.sim.coupling import Coupling, Driver, metered_step_s, sums_noise
from heatwright.sim.plants import Plant, plant_of
from heatwright.sim.reference.device import ReferenceDevice
from heatwright.sim.scenario import Action, Operable, actions, end_s
from heatwright.sim.trace import Series, StepLog, Trace, TraceEvent
from heatwright.spec import Controller, Event, ThermalNetwork
from heatwright.spec.board.timers import TICK_S

__all__ = ["STEP_S", "Device", "ReferenceDevice", "bench", "step_of"]

STEP_S = 0.2
"""Usual time step: a fifth of the usual control period. Plants integrate exactly within it; it is
only the resolution in time of the heater's power and the sensor's temperature."""
STEPS_PER_PERIOD = 2
"""Minimum number of time steps per control period: a fast loop makes the time step shorter."""

PROGRESS_REPORTS = 200

Progress = Callable[[float, float], None]
"""Called with the simulated time and the end, s."""


class Device(Driver, Operable, Protocol):
    """A controller seen from outside: the simulated binary or the reference model."""

    def sense(self, sensor: str, felt: float) -> None:
        """Give a sensor this temperature from now on, °C, or this current, A."""

    def advance(self, until_s: float) -> None:
        """Run to a time since power-up, s. What is due at exactly that time is done later."""

    def steps(self, loop: str) -> StepLog:
        """Return a row for every control step so far."""


def step_of(controller: Controller) -> float:
    """Return the machine's time step that a controller's loops and sensors need, s."""
    if any(sums_noise(controller, name) for name in controller.thermometers):
        return TICK_S  # the ADC reads once a tick, and each reading has its own noise
    return min(STEP_S, controller.shortest_period_s / STEPS_PER_PERIOD, metered_step_s(controller))


def bench(  # noqa: PLR0913 – all but two have defaults and names
    controller: Controller,
    device: Device,
    scenario: Iterable[Event] | None = None,
    *,
    plant: ThermalNetwork | None = None,
    step_s: float | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Trace:
    """Run a device against a machine and an operator.

    The run has one more time step after the end of the scenario, so that steps and events at the
    end are done.

    controller -- the specification; device -- the device under test; scenario -- the operator's
    events; the specification's if None; plant -- the machine; the specification's if None;
    step_s -- time step of the machine, s; if None, a step that suits the loops; seed -- seed of the
    sensor noise; progress -- called with the simulated time at intervals. Raises ValueError: the
    specification has no simulation, or the scenario no end.
    """
    simulation = controller.simulated
    step_s = step_s or step_of(controller)
    events = tuple(simulation.scenario if scenario is None else scenario)
    machine = plant_of(
        controller,
        plant or simulation.plant,
        ambient_c=simulation.ambient_c,
        step_s=step_s,
        seed=seed,
    )
    kind = Run if isinstance(device, ReferenceDevice) else _run_of(device)
    run = kind(controller, device, machine, actions(events), step_s, end_s(events))
    run.go(progress)
    return run.trace()


def _run_of(device: Device) -> type["Run"]:
    """Return the class that runs a device; simulated chips are imported only for the binary."""
    from heatwright.sim.beside import RunBeside  # noqa: PLC0415
    from heatwright.sim.device import AvrDevice  # noqa: PLC0415

    return RunBeside if isinstance(device, AvrDevice) else Run


class Run:
    """One run, row by row, with its plant in Python."""

    def __init__(  # noqa: PLR0913, PLR0917 – each is another part of the world
        self,
        controller: Controller,
        device: Device,
        plant: Plant,
        hand: tuple[Action, ...],
        step_s: float,
        end_s: float,
    ) -> None:
        self._device = device
        self._plant = plant
        self._coupling = Coupling(controller, device, step_s)
        self._hand = hand
        self._done = 0
        self._step_s = step_s
        self._count = count = round(end_s / step_s) + 1
        self._loops = tuple(controller.loops)
        self._sensors = tuple(plant.sensed_c())
        self._temperatures = np.empty((count + 1, len(plant.nodes)))
        self._sensed = np.empty((count + 1, len(self._sensors)))
        self._active = np.zeros((count + 1, len(self._coupling.loads)))
        self._fed = np.zeros(count + 1)
        self._meters = tuple(plant.currents_a())
        self._amperes = np.zeros((count + 1, len(self._meters)))

    def go(self, progress: Progress | None) -> None:
        plant, coupling, step_s = self._plant, self._coupling, self._step_s
        report_every = max(1, self._count // PROGRESS_REPORTS)
        felt = self._felt()
        self._note(0, felt)
        for row in range(1, self._count + 1):
            for sensor, value in felt.items():
                self._device.sense(sensor, value)
            self._advance(row * step_s)
            active = coupling.supplied(coupling.active())
            fed_mm_per_s = coupling.feed_mm_per_s()
            plant.step(active, fed_mm_per_s)
            felt = self._felt()
            self._note(row, felt)
            self._note_outputs(row, active, fed_mm_per_s)
            if progress is not None and row % report_every == 0:
                progress(row * step_s, self._count * step_s)

    def trace(self, steps: Mapping[str, StepLog] | None = None) -> Trace:
        if steps is None:
            steps = {loop: self._device.steps(loop) for loop in self._loops}
        return Trace(
            times_s=np.arange(self._count + 1, dtype=np.float64) * self._step_s,
            temperatures_c=_columns(self._plant.nodes, self._temperatures),
            sensed_c=_columns(self._sensors, self._sensed),
            on_fraction=_columns(self._coupling.loads, self._active),
            fed_mm_per_s=self._fed,
            currents_a=_columns(self._meters, self._amperes),
            steps=steps,
            events=_events(self._hand),
        )

    def _felt(self) -> Mapping[str, float]:
        """Return every sensor's temperature, then every sensor's current."""
        felt = self._plant.sensed_c()
        return felt | self._plant.currents_a() if self._meters else felt

    def _note(self, row: int, felt: Mapping[str, float]) -> None:
        values = tuple(felt.values())
        self._temperatures[row] = self._plant.temperatures_c
        self._sensed[row] = values[: len(self._sensors)]
        if self._meters:
            self._amperes[row] = values[len(self._sensors) :]

    def _note_outputs(self, row: int, active: Mapping[str, float], fed_mm_per_s: float) -> None:
        self._active[row] = tuple(active.values())
        self._fed[row] = fed_mm_per_s

    def _advance(self, until_s: float) -> None:
        """Run the device to a time, with the operator's actions before it."""
        while self._done < len(self._hand) and self._hand[self._done].time_s < until_s:
            action = self._hand[self._done]
            self._device.advance(action.time_s)
            action.give(self._device, self._coupling)
            self._done += 1
        self._device.advance(until_s)


def _events(hand: tuple[Action, ...]) -> tuple[TraceEvent, ...]:
    return tuple(
        TraceEvent(action.time_s, action.text, action.disturbs) for action in hand if action.text
    )


def _columns(names: tuple[str, ...], table: Series) -> dict[str, Series]:
    return {name: table[:, number] for number, name in enumerate(names)}
