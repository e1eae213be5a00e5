"""One control step of a loop, from the reading to the heater (docs/control.md, "The step")."""

from importlib import import_module
from typing import Protocol

from heatwright.sim.reference.guard import MOST_MISSING, Guard
from heatwright.sim.reference.guard_rules import Look
from heatwright.sim.reference.members import Member, Value, prefixed
from heatwright.sim.reference.numbers import ZERO, Single
from heatwright.sim.reference.output import HeaterOutput, heater_of
from heatwright.spec import Controller

Record = dict[str, Value]
"""Every member of the state after a step, by the names of docs/control.md."""

LOOP_MEMBERS: tuple[Member, ...] = (
    ("steps", "u2"),
    ("reading_status", "u1"),
    ("reading_raw", "i2"),
    ("setpoint_c", "f4"),
    ("temperature_c", "f4"),
    ("duty_percent", "f4"),
    ("asked_percent", "f4"),
    ("missing", "u1"),
    ("has_reading", "u1"),
)
FAULT_MEMBERS: tuple[Member, ...] = (
    ("code", "u1"),
    ("acknowledgements", "u1"),
    ("temperature_c", "f4"),
)


class Control(Protocol):
    """An algorithm: temperature in, duty out."""

    members: tuple[Member, ...]
    full_percent: Single

    def reset(self) -> None:
        """Start anew after a fault."""

    def step(self, temperature_c: Single, last_c: Single, gap: int, setpoint_c: Single) -> Single:
        """Return the duty in percent."""

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""


class Reference:
    """The reference model of one loop and the controller's fault latch."""

    def __init__(self, controller: Controller, loop: str) -> None:
        """Build the model from the specification alone."""
        spec = controller.loops[loop]
        sensor = controller.sensors[spec.sensor]
        self._convert = import_module(f"heatwright.sim.reference.{sensor.kind}").temperature
        algorithm = import_module(f"heatwright.sim.reference.{spec.algorithm.kind}")
        self._control: Control = algorithm.Control(spec.algorithm, spec.period_s)
        self._guard = Guard(spec, self._control.full_percent)
        self.output: HeaterOutput = heater_of(controller, spec.heater)
        self.members = self._members()
        self._names = tuple(name for name, _ in self.members)
        self._steps = 0
        self._temperature_c = ZERO
        self._duty_percent = ZERO
        self._asked_percent = ZERO
        self._missing = 0
        self._has_reading = 0
        self.fault_code = 0
        self.fault_temperature_c = ZERO
        self._acknowledgements = 0

    def restore(self, fault_code: int, temperature_c: Single) -> None:
        """Take over a fault that outlived a reset."""
        self.fault_code = fault_code
        self.fault_temperature_c = temperature_c

    def step(self, status: int, raw: int, setpoint: Single, *, acknowledge: bool = False) -> Record:
        """Do one control step.

        Args:
            status: 0 for a valid reading, else the code of what is wrong with it.
            raw: the sensor's code.
            setpoint: what the operator wants, °C.
            acknowledge: whether the operator acknowledged the fault since the last step.

        Returns:
            The state after the step.

        """
        if acknowledge and self.fault_code:
            self.fault_code = 0
            self._acknowledgements = (self._acknowledgements + 1) & 0xFF
            self._guard.reset()
        self._steps = (self._steps + 1) & 0xFFFF
        look = self._take(status, raw, setpoint)
        if not self.fault_code:
            self._protect(status, look)
        self._duty_percent = self._decide(status, look)
        if self.fault_code or not status:
            self._asked_percent = self._duty_percent
        self.output.apply(self._duty_percent)
        return dict(zip(self._names, self._values(status, raw, setpoint), strict=True))

    def _take(self, status: int, raw: int, setpoint: Single) -> Look:
        gap = self._missing + 1 if self._has_reading else 1
        last_c = self._temperature_c
        if status:
            self._missing = min(self._missing + 1, MOST_MISSING)
        else:
            self._temperature_c = self._convert(raw)
            if not self._has_reading:
                last_c = self._temperature_c
            self._missing = 0
            self._has_reading = 1
        return Look(
            self._temperature_c, last_c, gap, raw, setpoint, self._duty_percent, self._asked_percent
        )

    def _protect(self, status: int, look: Look) -> None:
        if status:
            code = self._guard.without_reading(status, self._missing)
        else:
            code = self._guard.with_reading(look)
        if code:
            self.fault_code = code
            self.fault_temperature_c = self._temperature_c

    def _decide(self, status: int, look: Look) -> Single:
        if self.fault_code:
            self._control.reset()
            return ZERO
        if status:
            return ZERO
        return self._control.step(look.temperature_c, look.last_c, look.gap, look.setpoint_c)

    def _members(self) -> tuple[Member, ...]:
        return (
            *LOOP_MEMBERS,
            *prefixed("guard", self._guard.members),
            *prefixed("algorithm", self._control.members),
            *prefixed("fault", FAULT_MEMBERS),
            *prefixed("output", self.output.members),
        )

    def _values(self, status: int, raw: int, setpoint: Single) -> tuple[Value, ...]:
        return (
            self._steps,
            status,
            raw,
            setpoint,
            self._temperature_c,
            self._duty_percent,
            self._asked_percent,
            self._missing,
            self._has_reading,
            *self._guard.values(),
            *self._control.values(),
            self.fault_code,
            self._acknowledgements,
            self.fault_temperature_c,
            *self.output.values(),
        )
