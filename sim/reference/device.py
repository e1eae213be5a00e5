"""The reference model as a device: it can take the binary's place on the bench."""

import numpy as np

from heatwright.sim.reference.course import Course, course_of
from heatwright.sim.reference.ds18b20 import IdealSensor
from heatwright.sim.reference.loop import Reference
from heatwright.sim.reference.numbers import Single
from heatwright.sim.trace import StepLog
from heatwright.spec import Controller, Loop

SECOND_US = 1_000_000
NO_READING = 4
"""Code of a step for which no reading came."""


class ReferenceDevice:
    """The control equations with ideal timing and ideal sensors, for one loop.

    Control steps are done at whole multiples of the period after power-up. The sensor is sampled
    when the firmware starts its conversion.
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
        self._sensor = IdealSensor(controller.sensors[self._loop.sensor])
        self._course: Course = course_of(controller, self._loop.heater)
        self._hand = _Hand(self._loop, _key_step_k(controller))
        self._period_us = round(self._loop.period_s * SECOND_US)
        self._step_us = self._period_us
        self._early_us = round(self._sensor.sampled_before_step_s * SECOND_US)
        self._sampled = False
        self._raw = 0
        self._felt_c = 0.0
        self._now_us = 0
        self._active_us = 0.0
        self._asked_us = dict.fromkeys(controller.outputs, 0)
        self._rows: list[tuple[object, ...]] = []

    def sense(self, sensor: str, temperature_c: float) -> None:
        """Give the sensor this temperature from now on, °C."""
        if sensor == self._loop.sensor:
            self._felt_c = temperature_c

    def press(self, key: str | None) -> None:
        """Hold a key from now on."""
        self._hand.press(key)

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
                self._raw = self._sensor.code(self._felt_c)
                self._sampled = True
        self._go(until_us)

    def on_fraction(self, output: str) -> float:
        """Return the mean active fraction (0..1) of an output since the last call."""
        elapsed_us = self._now_us - self._asked_us[output]
        self._asked_us[output] = self._now_us
        if output != self._loop.heater:
            return 1.0
        active_us, self._active_us = self._active_us, 0.0
        return active_us / elapsed_us if elapsed_us else 0.0

    def steps(self, loop: str) -> StepLog:
        """Return a row for every control step so far.

        Raises:
            KeyError: there is no such loop.

        """
        if loop != self._name:
            raise KeyError(loop)
        return np.array(self._rows, dtype=[("time_s", "f8"), *self._reference.members])

    def _go(self, to_us: int) -> None:
        self._active_us += self._course.advance(to_us)
        self._now_us = to_us

    def _do_step(self) -> None:
        record = self._reference.step(
            0, self._raw, self._hand.setpoint_c, acknowledge=self._hand.take_acknowledgement()
        )
        self._rows.append((self._step_us / SECOND_US, *record.values()))
        self._course.apply(self._reference.output.counts)
        self._step_us += self._period_us
        self._sampled = False


class _Hand:
    """What the keys do to the setpoint and the fault (docs/control.md, "Keys")."""

    def __init__(self, loop: Loop, step_k: float) -> None:
        self.setpoint_c = Single(loop.setpoint.initial_c)
        self._minimum_c = Single(loop.setpoint.minimum_c)
        self._maximum_c = Single(loop.setpoint.maximum_c)
        self._step_k = Single(step_k)
        self._key: str | None = None
        self._acknowledged = False

    def press(self, key: str | None) -> None:
        if key is None or key == self._key:
            self._key = key
            return
        self._key = key
        if key == "up":
            self.setpoint_c = min(self._maximum_c, self.setpoint_c + self._step_k)
        elif key == "down":
            self.setpoint_c = max(self._minimum_c, self.setpoint_c - self._step_k)
        elif key == "select":
            self._acknowledged = True

    def take_acknowledgement(self) -> bool:
        acknowledged, self._acknowledged = self._acknowledged, False
        return acknowledged


def _key_step_k(controller: Controller) -> float:
    for interface in controller.interfaces:
        if interface.kind == "lcd_keypad":
            return interface.step_k
    return 0.0
