"""One control step of a loop, from the reading to the heater (docs/control.md, "The step")."""

from collections.abc import Sequence

from heatwright.sim.reference.algorithms.response import response_of
from heatwright.sim.reference.control import Steering
from heatwright.sim.reference.inputs import AUTOMATIC, NO_ORDERS, Orders
from heatwright.sim.reference.numbers import FULL, ZERO, Member, Single, Value, prefixed
from heatwright.sim.reference.outputs.output import HeaterOutput, heater_of
from heatwright.sim.reference.programs.program import ProgramRun
from heatwright.sim.reference.protection.guard import Guard
from heatwright.sim.reference.protection.limiter import limiter_of
from heatwright.sim.reference.protection.monitor import MonitorModel
from heatwright.sim.reference.protection.rules import Look
from heatwright.sim.reference.sensors.reading import Average, Readings, Seen
from heatwright.spec import RULES, Controller, facts_of
from heatwright.spec.self_checks import SELF_CHECK_RULES

Record = dict[str, Value]
"""Every member of the state after a step, by the names of docs/control.md."""

EMERGENCY_STOP = 19
STOPS = (EMERGENCY_STOP, *(code for code, rule in RULES.items() if rule.id in SELF_CHECK_RULES))
"""Faults that are latched between two steps, with temperature 0."""
MASTER_LOST = 23
MEMORY_DAMAGED = 29
WATCHED_FAULTS = (25, 26, 28, 29, 31)
"""Faults of the relay, fans, memory and inputs, which are detected between two steps."""

FAULT_COOLING_ABOVE_C = Single(50)
"""While a fault is latched, the cooler runs unless a valid reading is below this temperature."""

LOOP_MEMBERS: tuple[Member, ...] = (
    ("steps", "u2"),
    ("setpoint_c", "f4"),
    ("duty_percent", "f4"),
    ("asked_percent", "f4"),
)
COOLING: Member = ("cooling", "u1")
PAUSED: Member = ("paused", "u1")
"""Input of all loops, if the machine has inputs."""
FAULT_MEMBERS: tuple[Member, ...] = (
    ("code", "u1"),
    ("acknowledgements", "u1"),
    ("temperature_c", "f4"),
)


class Reference:
    """The reference model of one loop and the controller's fault latch."""

    def __init__(self, controller: Controller, loop: str) -> None:
        """Build the model from the spec alone."""
        spec, facts = controller.loops[loop], facts_of(controller, loop)
        self._readings = Readings(controller, spec.sensor)
        self._guard = Guard(spec, self._readings.raw_width)
        self.steering = Steering(controller, loop)
        self.limiter = limiter_of(controller, spec)
        self.program = _program(controller, loop)
        self._response = response_of(spec)
        self._monitors = {name: MonitorModel(controller, name, spec) for name in facts.monitored}
        self._also = spec.also
        self._has_cooler = spec.cooler is not None
        self._has_inputs = facts.inputs
        self._minds_master = facts.master_lost
        self.output: HeaterOutput = heater_of(controller, spec.heater)
        self.members = self._members()
        self._names = tuple(name for name, _ in self.members)
        self._steps = 0
        self._duty_percent = ZERO
        self._asked_percent = ZERO
        self.cooling = 0
        """Whether the last step asked for the cooler."""
        self.order_waits = False
        """Whether the command to the program still waits after the last step."""
        self.fault_code = 0
        self.fault_temperature_c = ZERO
        self._acknowledgements = 0

    @property
    def duty_percent(self) -> Single:
        """The duty of the last step."""
        return self._duty_percent

    def restore(self, fault_code: int, temperature_c: Single) -> None:
        """Latch a fault with its temperature, such as one that survived a reset."""
        self.fault_code = fault_code
        self.fault_temperature_c = temperature_c

    def stop(self, code: int = EMERGENCY_STOP) -> None:
        """Latch a fault between two steps, by default the operator's stop.

        Does nothing if a fault is already latched.
        """
        if not self.fault_code:
            self.restore(code, ZERO)

    def acknowledge(self) -> None:
        """Acknowledge the fault, if there is one."""
        if self.fault_code:
            self.fault_code = 0
            self._acknowledgements = (self._acknowledgements + 1) & 0xFF
            self._guard.reset()
            if self.program:
                self.program.fail()

    def step(
        self,
        status: int,
        raw: int,
        setpoint: Single,
        *,
        acknowledge: bool = False,
        orders: Orders = NO_ORDERS,
    ) -> Record:
        """Run one control step.

        status -- 0 for a valid reading, otherwise the code of the fault; raw -- the sensor's code;
        setpoint -- the operator's setpoint, °C; acknowledge -- whether the operator acknowledged
        the fault since the last step; orders -- the other inputs, mostly commands.
        """
        if acknowledge:
            self.acknowledge()
        values = self.stepped(status, raw, setpoint, orders=orders)
        return dict(zip(self._names, values, strict=True))

    def stepped(
        self, status: int, raw: int, setpoint: Single, *, orders: Orders
    ) -> tuple[Value, ...]:
        """Run a step, and return the values of `members`."""
        self._steps = (self._steps + 1) & 0xFFFF
        if self._also is not None:
            self._mind_monitor(self._also, orders)
            status = status or orders.monitors[self._also][0]
        self._readings.take(status, raw, anew=bool(self._guard.fresh))
        orders, setpoint = self._run_program(status, orders, setpoint)
        look = self._look(self._readings.mean, raw, setpoint, orders)
        self._mind_others(orders, setpoint)
        self._mind_current(orders.current_raw)
        self._guard.take(orders.maximum_c)
        if not self.fault_code:
            self._protect(status, look)
        self._decide(status, look, orders)
        self.output.apply(self._duty_percent)
        self._measure(status, look, orders)
        if self.program:
            temperature_c = self._readings.mean.temperature_c
            self.program.count(self._duty_percent, temperature_c, fault=bool(self.fault_code))
        return self._values(setpoint, orders)

    @property
    def averages(self) -> dict[str, Average]:
        """By the prefix of a sensor's members: its average, whose window is not among them."""
        averages = {"": self._readings.average} | {
            f"monitor_{name}.": monitor.average for name, monitor in self._monitors.items()
        }
        return {prefix: each for prefix, each in averages.items() if each}

    @property
    def is_shown(self) -> bool:
        """Whether state and inputs are in `members` and `averages`: no window begins anew."""
        empty = any(each.is_empty for each in self.averages.values())
        return not empty and not (self._readings.average and self._guard.fresh)

    def resume(self, after: Sequence[Value]) -> None:
        """Continue as after a step that has returned these values.

        A program keeps its copy, and an average its window.
        """
        values = iter(after)
        self._steps, _, self._duty_percent, self._asked_percent = (next(values) for _ in range(4))
        self._readings.resume(values)
        if self._has_cooler:
            self.cooling = next(values)
        if self._has_inputs:
            next(values)
        self.steering.resume_inputs(values)
        self._guard.resume(values)
        self.steering.resume(values)
        if self.program:
            self.program.resume(values)
        self.fault_code, self._acknowledgements, self.fault_temperature_c = (
            next(values) for _ in range(3)
        )
        self.output.resume(values)
        if self.limiter:
            self.limiter.resume(values)
        if self._response:
            self._response.resume(values)
        for monitor in self._monitors.values():
            monitor.resume(values)

    def _run_program(self, status: int, orders: Orders, setpoint: Single) -> tuple[Orders, Single]:
        """Run the program's step, and return the commands and the setpoint that it makes."""
        if self.program is None:
            return orders, setpoint
        temperature_c = self._readings.mean.temperature_c
        code, self.order_waits = self.program.step(
            orders.program,
            None if status else temperature_c,
            reading_c=self._readings.single.temperature_c,
            fault=bool(self.fault_code),
            damaged=orders.watch_fault == MEMORY_DAMAGED and not self.fault_code,
        )
        self._trip(code, temperature_c)
        self.steering.follow(self.program.now.rate_k_per_s)
        return self.program.steered(orders, setpoint)

    def _look(self, seen: Seen, raw: int, setpoint: Single, orders: Orders) -> Look:
        full_percent, bandless, by_hand = self.steering.exemptions(setpoint, orders)
        return Look(
            *seen,
            self._readings.gap,
            raw,
            setpoint,
            self._duty_percent,
            self._asked_percent,
            full_percent,
            bandless,
            by_hand,
            ZERO if self._also is None else self._monitors[self._also].temperature_c,
            self.program is not None and self.program.moves,
            bool(self.cooling),
        )

    def _mind_others(self, orders: Orders, setpoint: Single) -> None:
        """Check relay, fans, inputs, monitors, the master, and how long the loop has been on."""
        temperature_c = self._readings.mean.temperature_c
        self._trip(orders.watch_fault, temperature_c)
        for name in self._monitors:
            if name != self._also:
                self._mind_monitor(name, orders)
        on = not self.steering.is_off(setpoint, orders)
        if orders.master_lost and self._minds_master and on:
            self._trip(MASTER_LOST, temperature_c)
        self._trip(self._guard.count(on=on and not self.fault_code), temperature_c)

    def _mind_monitor(self, name: str, orders: Orders) -> None:
        """Process a monitor's reading, and check it."""
        monitor = self._monitors[name]
        self._trip(monitor.step(*orders.monitors[name]), monitor.temperature_c)

    def _mind_current(self, raw: int) -> None:
        if self.limiter is None:
            return
        self.limiter.measure(raw, self._duty_percent)
        if self.fault_code:
            self.limiter.forget()
        else:
            self._trip(self.limiter.watch(), self._readings.mean.temperature_c)

    def _protect(self, status: int, look: Look) -> None:
        """Let the guard check the reading."""
        single = self._readings.single
        self._guard.feel(self._duty_percent)
        if status:
            code = self._guard.without_reading(status, self._readings.missing)
        else:
            alone = look._replace(**single._asdict()) if self._readings.average else look
            code = self._guard.with_reading(alone)
        self._trip(code, single.temperature_c)

    def _trip(self, code: int, temperature_c: Single) -> None:
        """Latch a fault, unless one is already latched or the code is 0."""
        if code and not self.fault_code:
            self.restore(code, temperature_c)

    def _decide(self, status: int, look: Look, orders: Orders) -> None:
        """Set the duty of the heater, and whether the cooler runs."""
        top_percent = FULL if self.limiter is None else self.limiter.top_percent
        asked_percent = self.steering.duty(
            look, orders, top_percent, fault=bool(self.fault_code), valid=not status
        )
        if self.fault_code or not status:
            self._asked_percent = asked_percent
        self._duty_percent = min(asked_percent, top_percent)
        if self._has_cooler:
            self.cooling = self._cooled(status, look, orders)

    def _measure(self, status: int, look: Look, orders: Orders) -> None:
        if self._response is None:
            return
        off = self.steering.is_idle(look.setpoint_c, orders) or orders.mode != AUTOMATIC
        self._response.step(
            None if status else look.temperature_c,
            look.setpoint_c,
            held=not (self.fault_code or off),
        )

    def _cooled(self, status: int, look: Look, orders: Orders) -> int:
        if self.fault_code:
            return int(bool(status) or not look.temperature_c < FAULT_COOLING_ABOVE_C)
        if self.steering.is_idle(look.setpoint_c, orders):
            return 0
        return self.cooling if status else self.steering.cooling

    def _members(self) -> tuple[Member, ...]:
        return (
            *LOOP_MEMBERS,
            *self._readings.members,
            *((COOLING,) if self._has_cooler else ()),
            *((PAUSED,) if self._has_inputs else ()),
            *self.steering.inputs,
            *prefixed("guard", self._guard.members),
            *self.steering.members,
            *prefixed("program", self.program.members if self.program else ()),
            *prefixed("fault", FAULT_MEMBERS),
            *prefixed("output", self.output.members),
            *prefixed("current", self.limiter.members if self.limiter else ()),
            *prefixed("response", self._response.members if self._response else ()),
            *(
                member
                for name, monitor in self._monitors.items()
                for member in prefixed(f"monitor_{name}", monitor.members)
            ),
        )

    def _values(self, setpoint: Single, orders: Orders) -> tuple[Value, ...]:
        return (
            self._steps,
            setpoint,
            self._duty_percent,
            self._asked_percent,
            *self._readings.values(),
            *((self.cooling,) if self._has_cooler else ()),
            *((orders.paused,) if self._has_inputs else ()),
            *self.steering.input_values(orders),
            *self._guard.values(),
            *self.steering.values(),
            *(self.program.values() if self.program else ()),
            self.fault_code,
            self._acknowledgements,
            self.fault_temperature_c,
            *self.output.values(),
            *(self.limiter.values() if self.limiter else ()),
            *(self._response.values() if self._response else ()),
            *(value for monitor in self._monitors.values() for value in monitor.values()),
        )


def _program(controller: Controller, loop: str) -> ProgramRun | None:
    if controller.programs is None or not facts_of(controller, loop).programmed:
        return None
    return ProgramRun(controller.programs, controller.loops[loop])
