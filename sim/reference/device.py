"""The reference model as a device: it can take the binary's place on the bench."""

from importlib import import_module

import numpy as np

from heatwright.sim.reference.driven import Driven
from heatwright.sim.reference.feed import Feed
from heatwright.sim.reference.host import Host
from heatwright.sim.reference.inputs import Gains
from heatwright.sim.reference.loop import Reference
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.operator import Operator
from heatwright.sim.trace import StepLog
from heatwright.spec import Controller, Stepper

SECOND_US = 1_000_000
DEFAULT_READY_K = 1.0


class ReferenceDevice:
    """The control equations with ideal timing and ideal sensors, for one loop.

    Control steps are done at whole multiples of the period after power-up. The sensor is sampled
    when the firmware starts its conversion. Keys and lines from a host act at once.
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
        sensor = controller.sensors[self._loop.sensor]
        kind = import_module(f"heatwright.sim.reference.{sensor.kind}")
        self._sensor = kind.IdealSensor(sensor, controller.board)
        self._driven, self._feeds = _outputs(controller)
        self._operator = Operator(controller, self._name, self._reference)
        self._host = Host(controller, self._operator, self._reference, self._driven, self._feeds)
        self._key: str | None = None
        self._key_step_k = Single(_key_step_k(controller))
        self._period_us = round(self._loop.period_s * SECOND_US)
        self._step_us = self._period_us
        self._early_us = round(self._sensor.sampled_before_step_s * SECOND_US)
        self._sampled = False
        self._reading = (0, 0)
        self._felt_c = 0.0
        self._rows: list[tuple[object, ...]] = []

    @property
    def gains(self) -> Gains | None:
        """The gains of the loop now, if they can be changed."""
        return self._operator.gains

    def sense(self, sensor: str, temperature_c: float) -> None:
        """Give the sensor this temperature from now on, °C."""
        if sensor == self._loop.sensor:
            self._felt_c = temperature_c

    def press(self, key: str | None) -> None:
        """Hold a key from now on."""
        pressed = key is not None and key != self._key
        self._key = key
        if not pressed:
            return
        if key == "up":
            self._operator.change(self._key_step_k)
        elif key == "down":
            self._operator.change(-self._key_step_k)
        elif key == "select":
            self._operator.acknowledge()

    def send(self, line: str) -> None:
        """Send a line of G-code; what the firmware would refuse changes nothing.

        Raises:
            ValueError: the controller has no host, or the line no command.

        """
        self._host.send(line)

    def advance(self, until_s: float) -> None:
        """Run to a time since power-up, s. What is due at that very time is done after it."""
        until_us = round(until_s * SECOND_US)
        while True:
            due_us = self._step_us if self._sampled else self._step_us - self._early_us
            if due_us >= until_us:
                break
            self._go(due_us)
            if self._sampled:
                self._do_step()
            else:
                self._reading = self._sensor.read(self._felt_c)
                self._sampled = True
        self._go(until_us)

    def on_fraction(self, output: str) -> float:
        """Return the mean active fraction (0..1) of an output since the last call."""
        return self._driven[output].on_fraction()

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
        return np.array(self._rows, dtype=[("time_s", "f8"), *self._reference.members])

    def _go(self, to_us: int) -> None:
        for driven in self._driven.values():
            driven.advance(to_us)
        for feed in self._feeds.values():
            feed.advance(to_us)

    def _do_step(self) -> None:
        record = self._reference.step(
            *self._reading, self._operator.setpoint_c, orders=self._operator.orders
        )
        self._rows.append((self._step_us / SECOND_US, *record.values()))
        self._driven[self._loop.heater].take(self._reference.output.counts)
        self._operator.after_step()
        self._mind_feeds(float(record["temperature_c"]))
        self._step_us += self._period_us
        self._sampled = False

    def _mind_feeds(self, temperature_c: float) -> None:
        within_k = self._loop.ready_within_k or DEFAULT_READY_K
        near = abs(temperature_c - float(self._operator.setpoint_c)) <= within_k
        status, _ = self._reading
        for feed in self._feeds.values():
            if self._reference.fault_code:
                feed.forget()
            feed.may_run = self._operator.is_automatic and near and not status


def _outputs(controller: Controller) -> tuple[dict[str, Driven], dict[str, Feed]]:
    driven, feeds = {}, {}
    for name, output in controller.outputs.items():
        if isinstance(output, Stepper):
            feeds[name] = Feed(output)
        else:
            driven[name] = Driven(controller, name)
    return driven, feeds


def _key_step_k(controller: Controller) -> float:
    for interface in controller.interfaces:
        if interface.kind == "lcd_keypad":
            return interface.step_k
    return 0.0
