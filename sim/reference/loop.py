"""One control step of a loop, from the reading to the heater (docs/control.md, "The step")."""

from importlib import import_module

from heatwright.sim.reference.control import Steering
from heatwright.sim.reference.guard import MOST_MISSING, Guard
from heatwright.sim.reference.guard_rules import Look
from heatwright.sim.reference.inputs import NO_ORDERS, Orders
from heatwright.sim.reference.limiter import limiter_of
from heatwright.sim.reference.members import Member, Value, prefixed
from heatwright.sim.reference.numbers import FULL, ZERO, Single
from heatwright.sim.reference.output import HeaterOutput, heater_of
from heatwright.spec import Controller

Record = dict[str, Value]
"""Every member of the state after a step, by the names of docs/control.md."""

EMERGENCY_STOP = 19
MASTER_LOST = 23

FAULT_COOLING_ABOVE_C = Single(50)
"""While a fault is latched the cooler runs, unless a reading tells that it is colder."""

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
COOLING: Member = ("cooling", "u1")
FAULT_MEMBERS: tuple[Member, ...] = (
    ("code", "u1"),
    ("acknowledgements", "u1"),
    ("temperature_c", "f4"),
)


class Reference:
    """The reference model of one loop and the controller's fault latch."""

    def __init__(self, controller: Controller, loop: str) -> None:
        """Build the model from the specification alone."""
        spec = controller.loops[loop]
        sensor = controller.sensors[spec.sensor]
        kind = import_module(f"heatwright.sim.reference.{sensor.kind}")
        self._convert = kind.converter(sensor, controller.board)
        self._guard = Guard(spec)
        self.steering = Steering(controller, loop)
        self.limiter = limiter_of(controller, spec.heater, spec.period_s)
        self._has_cooler = spec.cooler is not None
        self._minds_master = spec.protection.master_lost_after_s is not None
        self.output: HeaterOutput = heater_of(controller, spec.heater)
        self.members = self._members()
        self._names = tuple(name for name, _ in self.members)
        self._steps = 0
        self._temperature_c = ZERO
        self._duty_percent = ZERO
        self._asked_percent = ZERO
        self._missing = 0
        self._has_reading = 0
        self.cooling = 0
        """Whether the cooler is asked for."""
        self.fault_code = 0
        self.fault_temperature_c = ZERO
        self._acknowledgements = 0

    @property
    def duty_percent(self) -> Single:
        """What the last step asked for."""
        return self._duty_percent

    def restore(self, fault_code: int, temperature_c: Single) -> None:
        """Take over a fault that outlived a reset."""
        self.fault_code = fault_code
        self.fault_temperature_c = temperature_c

    def stop(self) -> None:
        """Stop at the operator's command, unless a fault is latched already."""
        if not self.fault_code:
            self.restore(EMERGENCY_STOP, ZERO)

    def acknowledge(self) -> None:
        """Let the operator acknowledge the fault, if there is one."""
        if self.fault_code:
            self.fault_code = 0
            self._acknowledgements = (self._acknowledgements + 1) & 0xFF
            self._guard.reset()

    def step(
        self,
        status: int,
        raw: int,
        setpoint: Single,
        *,
        acknowledge: bool = False,
        orders: Orders = NO_ORDERS,
    ) -> Record:
        """Do one control step.

        Args:
            status: 0 for a valid reading, else the code of what is wrong with it.
            raw: the sensor's code.
            setpoint: what the operator wants, °C.
            acknowledge: whether the operator acknowledged the fault since the last step.
            orders: what else goes in, mostly what a host wants of a commanded loop.

        Returns:
            The state after the step.

        """
        if acknowledge:
            self.acknowledge()
        self._steps = (self._steps + 1) & 0xFFFF
        look = self._take(status, raw, setpoint, orders)
        if orders.master_lost and self._minds_master and orders.enabled:
            self._trip(MASTER_LOST)
        self._mind_current(orders.current_raw)
        if not self.fault_code:
            self._protect(status, look)
        self._decide(status, look, orders)
        self.output.apply(self._duty_percent)
        values = self._values(status, raw, setpoint, orders)
        return dict(zip(self._names, values, strict=True))

    def _take(self, status: int, raw: int, setpoint: Single, orders: Orders) -> Look:
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
            self._temperature_c,
            last_c,
            gap,
            raw,
            setpoint,
            self._duty_percent,
            self._asked_percent,
            *self.steering.exemptions(setpoint, orders),
        )

    def _mind_current(self, raw: int) -> None:
        if self.limiter is None:
            return
        self.limiter.measure(raw, self._duty_percent)
        if self.fault_code:
            self.limiter.forget()
        else:
            self._trip(self.limiter.watch())

    def _protect(self, status: int, look: Look) -> None:
        if status:
            code = self._guard.without_reading(status, self._missing)
        else:
            code = self._guard.with_reading(look)
        self._trip(code)

    def _trip(self, code: int) -> None:
        """Latch a fault, unless there is one already or the code is that of none."""
        if code and not self.fault_code:
            self.restore(code, self._temperature_c)

    def _decide(self, status: int, look: Look, orders: Orders) -> None:
        """Find what heater and cooler are asked for."""
        top_percent = FULL if self.limiter is None else self.limiter.top_percent
        asked_percent = self.steering.duty(
            look, orders, top_percent, fault=bool(self.fault_code), valid=not status
        )
        if self.fault_code or not status:
            self._asked_percent = asked_percent
        self._duty_percent = min(asked_percent, top_percent)
        if self._has_cooler:
            self.cooling = self._cooled(status, look, orders)

    def _cooled(self, status: int, look: Look, orders: Orders) -> int:
        if self.fault_code:
            return int(bool(status) or not look.temperature_c < FAULT_COOLING_ABOVE_C)
        if self.steering.is_off(look.setpoint_c, orders):
            return 0
        return self.cooling if status else self.steering.cooling

    def _members(self) -> tuple[Member, ...]:
        return (
            *LOOP_MEMBERS,
            *((COOLING,) if self._has_cooler else ()),
            *self.steering.inputs,
            *prefixed("guard", self._guard.members),
            *self.steering.members,
            *prefixed("fault", FAULT_MEMBERS),
            *prefixed("output", self.output.members),
            *prefixed("current", self.limiter.members if self.limiter else ()),
        )

    def _values(self, status: int, raw: int, setpoint: Single, orders: Orders) -> tuple[Value, ...]:
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
            *((self.cooling,) if self._has_cooler else ()),
            *self.steering.input_values(orders),
            *self._guard.values(),
            *self.steering.values(),
            self.fault_code,
            self._acknowledgements,
            self.fault_temperature_c,
            *self.output.values(),
            *(self.limiter.values() if self.limiter else ()),
        )
