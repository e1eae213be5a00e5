"""One loop of the reference device: its sensor, its operator, its model and its steps."""

from collections import deque
from importlib import import_module
from random import Random
from typing import Any, Protocol, cast

import numpy as np

from heatwright.sim.coupling import sums_noise
from heatwright.sim.reference.interfaces.operator import Operator
from heatwright.sim.reference.interfaces.pages import CountdownKeys
from heatwright.sim.reference.interfaces.switched import SwitchedOperator
from heatwright.sim.reference.loop import Record, Reference
from heatwright.sim.reference.numbers import SECOND_US, TICK_US, Single, period_us
from heatwright.sim.reference.programs.copies import Cell, cell_of, column_of
from heatwright.sim.reference.programs.orders import ProgrammedOperator
from heatwright.sim.reference.sensors.current import IdealSensor
from heatwright.sim.trace import StepLog
from heatwright.spec import Controller, facts_of
from heatwright.spec.registry import module_of


class Sampler:
    """The reading of a sensor for the next step of a loop.

    All codes are sampled at the same time. If the machine makes noise, each is sampled in its own
    tick, because the noise of their sum is averaged.
    """

    def __init__(self, controller: Controller, name: str, noise_k: float = 0.0) -> None:
        """Derive when the sensor `name` has to be sampled.

        noise_k -- standard deviation of the noise that each sample adds, K.
        """
        sensor = controller.sensors[name]
        kind = import_module(module_of("sensor", "reference", sensor.kind))
        self._sensor: Any = kind.IdealSensor(sensor, controller.board)
        self._each = sums_noise(controller, name)
        early_us = round(self._sensor.sampled_before_step_s * SECOND_US)
        self._early_us = [early_us]
        if self._each:
            self._early_us = [turn * TICK_US for turn in range(self._sensor.oversample, 0, -1)]
        self._felt_c: list[float] = []
        self._noise_k = noise_k
        self._random = Random(0)  # noqa: S311 - no secret

    def due_us(self, step_us: int) -> int:
        """Return when to sample next, µs; the time of the step if all samples are taken."""
        looks = len(self._felt_c)
        return step_us - self._early_us[looks] if looks < len(self._early_us) else step_us

    @property
    def is_done(self) -> bool:
        """Whether the reading is complete."""
        return len(self._felt_c) == len(self._early_us)

    def look(self, temperature_c: float) -> None:
        """Sample the present temperature, °C."""
        if self._noise_k:
            temperature_c += self._random.gauss(0.0, self._noise_k)
        self._felt_c.append(temperature_c)

    def take(self) -> tuple[int, int]:
        """Return the reading's status and raw number, and begin the next one."""
        felt_c, self._felt_c = self._felt_c, []
        status, raw = self._sensor.read_all(felt_c) if self._each else self._sensor.read(felt_c[0])
        return status, raw


DEFAULT_READY_K = 1.0


class Feels(Protocol):
    """The present values of the sensors: temperatures, °C, and currents, A."""

    def __getitem__(self, sensor: str) -> float:
        """Return the value of a sensor."""


class ModelledLoop:
    """A loop with an ideal sensor and control steps at whole multiples of its period.

    The sensor is sampled when the firmware starts its conversion.
    """

    def __init__(
        self,
        controller: Controller,
        name: str,
        felt: Feels,
        noise_k: float = 0.0,
        most_rows: int | None = None,
    ) -> None:
        """Power up.

        felt -- the values of its sensors; noise_k -- noise added at each reading of the loop's own
        sensor, K; most_rows -- how many of its steps are kept, None: all.
        """
        self.name = name
        self.spec, facts = controller.loops[name], facts_of(controller, name)
        self.reference = Reference(controller, name)
        self._names = ["time_s", *dict(self.reference.members)]
        self.operator = _operator(controller, name, self.reference)
        self.countdown = _countdown(controller, name, self.operator)
        self.is_ready = False
        """Whether the temperature was near enough to the setpoint in the last step."""
        self._monitors = {
            each: (monitor.sensor, Sampler(controller, monitor.sensor))
            for each, monitor in facts.monitored.items()
        }
        own = (self.spec.sensor, Sampler(controller, self.spec.sensor, noise_k))
        self._samplers = (own, *self._monitors.values())
        self._felt = felt
        self._ammeter = _ammeter(controller, name)
        self._period_us = period_us(self.spec)
        self._step_us = self._period_us
        self._rows: deque[tuple[object, ...]] = deque(maxlen=most_rows)
        programs = controller.programs
        self._points = programs.points if programs and facts.programmed else 0
        self.due_us = 0
        """Time of the next reading or step, µs."""
        self._plan()

    def do(self) -> bool:
        """Do the reading or step that is due; return whether it was a step."""
        due_us = self.due_us
        for sensor, sampler in self._samplers:
            if not sampler.is_done and sampler.due_us(self._step_us) == due_us:
                sampler.look(self._felt[sensor])
                self._plan()
                return False
        (status, raw), *others = [sampler.take() for _, sampler in self._samplers]
        orders = self.operator.orders
        if others:
            orders = orders._replace(monitors=dict(zip(self._monitors, others, strict=True)))
        if self._ammeter is not None:
            sensor, ideal = self._ammeter
            orders = orders._replace(current_raw=ideal.read(self._felt[sensor])[1])
        record = self.reference.step(status, raw, self.operator.setpoint_c, orders=orders)
        self._rows.append((self._step_us / SECOND_US, *record.values(), *self._loaded()))
        self.operator.after_step()
        if self.countdown is not None:
            self.countdown.after_step(warm=self._is_warm(record))
        within_k = self.spec.ready_within_k or DEFAULT_READY_K
        error_k = float(record["temperature_c"]) - float(self.operator.setpoint_c)
        self.is_ready = self.operator.is_automatic and abs(error_k) <= within_k and not status
        self._step_us += self._period_us
        self._plan()
        return True

    def _plan(self) -> None:
        self.due_us = min([sampler.due_us(self._step_us) for _, sampler in self._samplers])

    def take_fault(self, code: int, temperature_c: Single, with_step_s: float = 0.0) -> None:
        """Stop because of a fault that was latched outside this loop's steps.

        A fault from another loop's step at the same time is also in the row of this loop's step.
        """
        if self.reference.fault_code:
            return
        self.reference.restore(code, temperature_c)
        self.operator.see_fault()
        if self._rows and self._rows[-1][0] == with_step_s:
            fault = {"fault.code": code, "fault.temperature_c": temperature_c}
            row = self._rows[-1]
            changed = {self._names.index(name): value for name, value in fault.items()}
            self._rows[-1] = tuple(changed.get(place, value) for place, value in enumerate(row))

    @property
    def step_s(self) -> float:
        """Time of the last step, s."""
        return (self._step_us - self._period_us) / SECOND_US

    def steps(self) -> StepLog:
        """Return a row for every control step so far."""
        dtype = [("time_s", "f8"), *self.reference.members, *column_of(self._points)]
        return np.array(list(self._rows), dtype=dtype)

    def last(self, member: str) -> float:
        """Return a member of the last step. Raises ValueError: there is none."""
        if not self._rows:
            raise ValueError(f"no step has recorded {member}")
        return cast("float", self._rows[-1][self._names.index(member)])

    def _is_warm(self, record: Record) -> bool:
        """Return whether the loop was on and within its band around the setpoint in a step."""
        if not record["enabled"] or record["fault.code"] or record["reading_status"]:
            return False
        within_k = self.spec.algorithm.warm_within_k
        if within_k is None:
            within_k = self.spec.ready_within_k or DEFAULT_READY_K
        error_k = Single(record["setpoint_c"]) - Single(record["temperature_c"])
        return bool(-Single(within_k) <= error_k <= Single(within_k))

    def _loaded(self) -> tuple[Cell, ...]:
        """Return the copy of the program, for the log."""
        run = self.reference.program
        return () if run is None else (cell_of(run.copy, self._points),)


def _operator(controller: Controller, name: str, reference: Reference) -> Operator:
    if facts_of(controller, name).programmed:
        return ProgrammedOperator(controller, name, reference)
    if facts_of(controller, name).switched:
        return SwitchedOperator(controller, name, reference)
    return Operator(controller, name, reference)


def _countdown(controller: Controller, name: str, operator: Operator) -> CountdownKeys | None:
    countdown = facts_of(controller, name).countdown
    if countdown is None or not isinstance(operator, SwitchedOperator):
        return None
    return CountdownKeys(countdown, controller.loops[name], operator)


def _ammeter(controller: Controller, name: str) -> tuple[str, IdealSensor] | None:
    """Return name and sensor of a loop's current; None if its heater's is not measured."""
    current = facts_of(controller, name).current
    if current is None:
        return None
    return current.sensor, IdealSensor(controller.ammeters[current.sensor], controller.board)
