"""The source of the duty: algorithm, operator, or tuning (docs/control.md, "Modes")."""

from collections.abc import Iterator
from importlib import import_module
from typing import NamedTuple, Protocol

from heatwright.sim.reference.algorithms.autotune import SLOPE, Moment, Tuner
from heatwright.sim.reference.algorithms.keyed_switch import KeyedSwitch
from heatwright.sim.reference.algorithms.pid import PidControl, gains_of, tunable_pid
from heatwright.sim.reference.algorithms.three_position import ThreePositionControl
from heatwright.sim.reference.inputs import AUTOMATIC, MANUAL, TUNING, Limits, Orders
from heatwright.sim.reference.interfaces.keyed import in_range
from heatwright.sim.reference.numbers import ZERO, Member, Single, Value, prefixed
from heatwright.sim.reference.protection.rules import Look
from heatwright.spec import Controller, Loop, facts_of
from heatwright.spec.adjusted import Number
from heatwright.spec.registry import module_of

ENABLED: Member = ("enabled", "u1")
"""Input of a switched loop."""
INPUTS: tuple[Member, ...] = (("mode", "u1"), ("manual_percent", "f4"))
"""Inputs of a tunable loop."""
LIMITS: tuple[Member, ...] = (
    ("integral_minimum_percent", "f4"),
    ("integral_maximum_percent", "f4"),
    ("output_maximum_percent", "f4"),
)
"""Inputs of a loop whose limits are adjustable."""


class Control(Protocol):
    """An algorithm: temperature in, duty out."""

    members: tuple[Member, ...]
    full_percent: Single

    def reset(self) -> None:
        """Start again after a fault."""

    def step(self, temperature_c: Single, last_c: Single, gap: int, setpoint_c: Single) -> Single:
        """Return the duty in percent."""

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""

    def resume(self, values: Iterator[Value]) -> None:
        """Take over the next values, one for each of `members`."""


class Exemptions(NamedTuple):
    """Exemptions from protections that follow from the mode; see `Look`."""

    full_percent: Single
    bandless: bool
    by_hand: bool


class Steering:
    """The algorithm of a loop, or the manual duty or tuning that replaces it."""

    def __init__(self, controller: Controller, loop: str) -> None:
        """Create the loop's algorithm, manual duty and tuning."""
        spec = controller.loops[loop]
        self._facts = facts = facts_of(controller, loop)
        self._gains = gains_of(spec.algorithm)
        self._pid = tunable_pid(spec, facts) if facts.gains_vary else None
        self._limited = self._pid is not None and facts.limits_adjustable
        self._control: Control = self._pid or _constant(spec, facts.keyed_numbers)
        pid, experiment = spec.algorithm.pid, spec.autotune
        self.tuner = Tuner(spec, experiment, pid) if facts.autotune and experiment and pid else None
        self.inputs: tuple[Member, ...] = (
            *((ENABLED,) if facts.switched else ()),
            *(INPUTS if facts.tunable else ()),
            *(LIMITS if self._limited else ()),
        )
        self.members: tuple[Member, ...] = prefixed("algorithm", self._control.members)
        if self.tuner:
            self.members += prefixed("autotune", self.tuner.members)

    @property
    def cooling(self) -> int:
        """Whether the algorithm requests cooling."""
        return self._control.cooling if isinstance(self._control, ThreePositionControl) else 0

    def exemptions(self, setpoint_c: Single, orders: Orders) -> Exemptions:
        """Return the exemptions from protections in the present mode."""
        mode = orders.mode
        full_percent = self._control.full_percent
        bandless = mode == MANUAL
        if self.tuner and mode == TUNING:
            full_percent = self.tuner.swing_percent
            bandless = self.tuner.phase <= SLOPE
        bandless = bandless or self.is_idle(setpoint_c, orders)
        return Exemptions(full_percent, bandless, mode == MANUAL)

    def duty(
        self, look: Look, orders: Orders, top_percent: Single, *, fault: bool, valid: bool
    ) -> Single:
        """Return the duty in percent; `top_percent` limits only the integral, not yet the duty."""
        off = self.is_idle(look.setpoint_c, orders)
        self._take_limits(orders.limits)
        if self.tuner:
            self.tuner.stop_unless(orders.mode, fault=fault)
            moment = Moment(look.temperature_c, look.last_c, look.setpoint_c)
            tuning_percent = self.tuner.step(moment if valid else None, paused=bool(orders.paused))
        if fault or (valid and (off or orders.mode == TUNING)):
            self._control.reset()
        if fault or not valid or off:
            return ZERO
        if orders.mode == TUNING:
            return tuning_percent if self.tuner else ZERO
        return self._steered(look, orders, top_percent)

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""
        return (*self._control.values(), *(self.tuner.values() if self.tuner else ()))

    def resume_inputs(self, values: Iterator[Value]) -> None:
        """Take over the next values, one for each of `inputs`; limits count until the next ones."""
        taken = [next(values) for _ in self.inputs]
        if self._limited:
            self._take_limits(Limits._make(taken[-len(LIMITS) :]))

    def resume(self, values: Iterator[Value]) -> None:
        """Take over the next values, one for each of `members`."""
        self._control.resume(values)
        if self.tuner:
            self.tuner.resume(values)

    def follow(self, rate_k_per_s: Single) -> None:
        """Take over the slope of a program's setpoint."""
        if self._pid:
            self._pid.rate_k_per_s = rate_k_per_s

    def input_values(self, orders: Orders) -> tuple[Value, ...]:
        """Return the values of `inputs`."""
        return (
            *((orders.enabled,) if self._facts.switched else ()),
            *((orders.mode, orders.manual_percent) if self._facts.tunable else ()),
            *(self._pid.limits if self._limited and self._pid else ()),
        )

    def is_off(self, setpoint_c: Single, orders: Orders) -> bool:
        """Return whether a commanded loop is off."""
        if self._facts.switched:
            return not orders.enabled
        return self._facts.hosted and orders.mode == AUTOMATIC and bool(setpoint_c == ZERO)

    def is_idle(self, setpoint_c: Single, orders: Orders) -> bool:
        """Return whether the loop must not heat: off, or paused by an input of the machine."""
        return bool(orders.paused) or self.is_off(setpoint_c, orders)

    def _take_limits(self, limits: Limits | None) -> None:
        if self._limited and self._pid:
            self._pid.take_limits(limits)
            if self.tuner:
                self.tuner.take_limits(self._pid.limits)

    def _steered(self, look: Look, orders: Orders, top_percent: Single) -> Single:
        if isinstance(self._control, PidControl):
            self._control.top_percent = top_percent
        numbers = in_range(self._facts.keyed_numbers, orders.numbers)
        if isinstance(self._control, KeyedSwitch):
            self._control.take(numbers)
        if self._pid:
            gains = orders.gains if self._facts.tunable else self._gains
            if gains is None:
                raise ValueError("A tunable loop needs its gains")
            self._pid.take(gains._replace(**numbers) if numbers else gains)
            if orders.mode == MANUAL:
                return self._pid.follow(
                    look.temperature_c, look.gap, look.setpoint_c, orders.manual_percent
                )
        return self._control.step(look.temperature_c, look.last_c, look.gap, look.setpoint_c)


def _constant(spec: Loop, numbers: tuple[Number, ...]) -> Control:
    module = import_module(module_of("algorithm", "reference", spec.algorithm.kind))
    keyed = [tuple(each.kind.field for each in numbers)] if numbers else []
    control: Control = module.Control(spec.algorithm, spec.period_s, *keyed)
    return control
