"""The reference model as a device: it can take the binary's place on the bench."""

import numpy as np

from heatwright.sim.reference.copies import Cell, cell_of, column_of
from heatwright.sim.reference.current import IdealSensor
from heatwright.sim.reference.display import Display
from heatwright.sim.reference.driven import Driven
from heatwright.sim.reference.feed import Feed
from heatwright.sim.reference.host import Host
from heatwright.sim.reference.inputs import Gains
from heatwright.sim.reference.loop import Reference
from heatwright.sim.reference.master import Master
from heatwright.sim.reference.numbers import FULL, ZERO, Single
from heatwright.sim.reference.operator import Operator
from heatwright.sim.reference.programmed import ProgrammedOperator
from heatwright.sim.reference.sampling import Sampler
from heatwright.sim.reference.switched import SwitchedOperator
from heatwright.sim.trace import StepLog
from heatwright.spec import (
    Controller,
    CurrentSensor,
    Stepper,
    modbus_of,
    nextion_of,
    programmed,
    switched,
)
from heatwright.spec.program_orders import Order

SECOND_US = 1_000_000
DEFAULT_READY_K = 1.0


class ReferenceDevice:
    """The control equations with ideal timing and ideal sensors, for one loop.

    Control steps are done at whole multiples of the period after power-up. The sensor is sampled
    when the firmware starts its conversion. Keys, lines from a host or a display, a master's writes
    and orders to a program act at once.
    """

    def __init__(self, controller: Controller) -> None:
        """Power up.

        Raises:
            ValueError: the controller has more than one loop.

        """
        if len(controller.loops) != 1:
            message = "The reference device has one loop"
            raise ValueError(message)
        ((self._name, self._loop),) = controller.loops.items()
        self._reference = Reference(controller, self._name)
        self._sampler = Sampler(controller, self._loop)
        self._driven, self._feeds = _outputs(controller)
        self._operator = _operator(controller, self._name, self._reference)
        self._master: Master | None = None
        if modbus_of(controller) and isinstance(self._operator, SwitchedOperator):
            self._master = Master(controller, self._name, self._operator, self._reference)
        self._display = Display(controller, self._operator) if nextion_of(controller) else None
        self._host = Host(controller, self._operator, self._reference, self._driven, self._feeds)
        self._key: str | None = None
        self._key_step_k = Single(_key_step_k(controller))
        self._period_us = round(self._loop.period_s * SECOND_US)
        self._step_us = self._period_us
        self._felt_c = 0.0
        self._ammeter = _ammeter(controller, self._loop.heater)
        self._amperes = 0.0
        self._rows: list[tuple[object, ...]] = []
        self._points = controller.programs.points if controller.programs else 0

    @property
    def gains(self) -> Gains | None:
        """The gains of the loop now, if they can be changed."""
        return self._operator.gains

    def sense(self, sensor: str, felt: float) -> None:
        """Give a sensor this temperature from now on, °C, or this current, A."""
        if sensor == self._loop.sensor:
            self._felt_c = felt
        elif self._ammeter is not None and sensor == self._ammeter[0]:
            self._amperes = felt

    def press(self, key: str | None) -> None:
        """Hold a key from now on."""
        pressed = key is not None and key != self._key
        self._key = key
        if not pressed or (self._reference.fault_code and key != "select"):
            return
        if key == "up":
            self._operator.change(self._key_step_k)
        elif key == "down":
            self._operator.change(-self._key_step_k)
        elif key == "left":
            self._operator.key_off()
        elif key == "select":
            self._operator.acknowledge()

    def send(self, line: str) -> None:
        """Send a line of G-code, or what a display sends; what is refused changes nothing.

        Raises:
            ValueError: the controller has neither host nor display, or the line no command.

        """
        if self._display is not None:
            self._display.send(line)
        else:
            self._host.send(line)

    def program(self, order: Order, number: int = 0) -> None:
        """Give an order to the program; what the firmware would refuse changes nothing.

        Raises:
            ValueError: the controller has no programs.

        """
        operator = self._operator if isinstance(self._operator, ProgrammedOperator) else None
        if operator is None:
            message = "The specification has no programs"
            raise ValueError(message)
        operator.order(order, number)

    def write(self, name: str, value: float | bool) -> None:
        """Let the master write a value; what the firmware would refuse changes nothing.

        Raises:
            ValueError: the controller has no master.
            KeyError: there is nothing of that name.

        """
        if self._master is None:
            message = "The specification has no modbus_rtu interface"
            raise ValueError(message)
        self._master.write(name, value)

    def advance(self, until_s: float) -> None:
        """Run to a time since power-up, s. What is due at that very time is done after it."""
        until_us = round(until_s * SECOND_US)
        while True:
            due_us = self._sampler.due_us(self._step_us)
            if due_us >= until_us:
                break
            self._go(due_us)
            if self._sampler.is_done:
                self._do_step()
            else:
                self._sampler.look(self._felt_c)
        self._go(until_us)

    def on_fraction(self, output: str) -> float:
        """Return the mean active fraction (0..1) of an output since the last call."""
        return self._driven[output].on_fraction()

    def relay_fraction(self) -> float:
        """Return 1: an ideal relay is closed whenever a heater is on."""
        return 1.0

    def travel_mm(self, output: str) -> float:
        """Return what a stepper has fed since the last call, mm."""
        return self._feeds[output].travel_mm()

    def steps(self, loop: str) -> StepLog:
        """Return a row for every control step so far.

        Raises:
            KeyError: there is no such loop.

        """
        if loop != self._name:
            raise KeyError(loop)
        dtype = [("time_s", "f8"), *self._reference.members, *column_of(self._points)]
        return np.array(self._rows, dtype=dtype)

    def _go(self, to_us: int) -> None:
        for driven in self._driven.values():
            driven.advance(to_us)
        for feed in self._feeds.values():
            feed.advance(to_us)

    def _do_step(self) -> None:
        status, raw = self._sampler.take()
        orders = self._operator.orders
        if self._ammeter is not None:
            orders = orders._replace(current_raw=self._ammeter[1].read(self._amperes)[1])
        record = self._reference.step(status, raw, self._operator.setpoint_c, orders=orders)
        self._rows.append((self._step_us / SECOND_US, *record.values(), *self._loaded()))
        self._driven[self._loop.heater].take(self._reference.output.counts)
        if self._loop.cooler is not None:
            self._driven[self._loop.cooler].set(FULL if self._reference.cooling else ZERO)
        self._operator.after_step()
        self._mind_feeds(float(record["temperature_c"]), valid=not status)
        self._step_us += self._period_us

    def _loaded(self) -> tuple[Cell, ...]:
        """Return the copy of the program, for the log."""
        run = self._reference.program
        return () if run is None else (cell_of(run.copy, self._points),)

    def _mind_feeds(self, temperature_c: float, *, valid: bool) -> None:
        within_k = self._loop.ready_within_k or DEFAULT_READY_K
        near = abs(temperature_c - float(self._operator.setpoint_c)) <= within_k
        for feed in self._feeds.values():
            if self._reference.fault_code:
                feed.forget()
            feed.may_run = self._operator.is_automatic and near and valid


def _operator(controller: Controller, name: str, reference: Reference) -> Operator:
    if programmed(controller, name):
        return ProgrammedOperator(controller, name, reference)
    if switched(controller, name):
        return SwitchedOperator(controller, name, reference)
    return Operator(controller, name, reference)


def _outputs(controller: Controller) -> tuple[dict[str, Driven], dict[str, Feed]]:
    driven, feeds = {}, {}
    for name, output in controller.outputs.items():
        if isinstance(output, Stepper):
            feeds[name] = Feed(output)
        else:
            driven[name] = Driven(controller, name)
    return driven, feeds


def _ammeter(controller: Controller, heater: str) -> tuple[str, IdealSensor] | None:
    """Return the sensor of a heater's current, and its name; None if it is not measured."""
    current = getattr(controller.outputs[heater], "current", None)
    if current is None:
        return None
    sensor = controller.sensors[current.sensor]
    assert isinstance(sensor, CurrentSensor)  # noqa: S101 - the language allows no other
    return current.sensor, IdealSensor(sensor, controller.board)


def _key_step_k(controller: Controller) -> float:
    for interface in controller.interfaces:
        if interface.kind == "lcd_keypad":
            return interface.step_k
    return 0.0
