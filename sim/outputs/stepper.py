"""A stepper motor behind a driver with STEP, DIR and ENABLE.

The driver counts rising edges of STEP, as an A4988 or DRV8825 does. Times between edges are checked
against the stricter of their data sheets: a step that the driver could miss, or make in the wrong
direction, is a violation. A step while the driver is not enabled does not move the motor.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.avr import Avr
from heatwright.sim.outputs.switch import Switch
from heatwright.spec import Board
from heatwright.spec import Stepper as StepperOutput


class DriverTiming(NamedTuple):
    """Minimum times of a driver, s."""

    high_s: float
    low_s: float
    setup_s: float
    """Time from a change of DIR or ENABLE to a rise of STEP."""
    hold_s: float
    """Time from a rise of STEP to a change of DIR."""


DRV8825 = DriverTiming(1.9e-6, 1.9e-6, 650e-9, 650e-9)
"""Texas Instruments SLVSA73, timing requirements: every time is stricter than the A4988's."""

STEP = np.dtype([("cycle", "<u8"), ("way", "i1")])
"""A step: its cycle, and +1 forward, -1 backward, 0 no movement."""


class _Line:
    """The level of a line at any time, from its changes."""

    def __init__(self, number: int, level: bool) -> None:
        self.number = number
        self._cycles = np.zeros(1, np.int64)
        self._levels = np.array([level])

    def feed(self, events: NDArray[Any]) -> None:
        """Process this pin's changes; of earlier ones only the last is kept."""
        mine = events[events["pin"] == self.number]
        levels = np.concatenate((self._levels[-1:], mine["state"] & 1 == 1))
        cycles = np.concatenate((self._cycles[-1:], mine["cycle"].astype(np.int64)))
        changed = np.concatenate(([True], levels[1:] != levels[:-1]))
        self._cycles, self._levels = cycles[changed], levels[changed]

    @property
    def edges(self) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Cycle and new level of each change; the first one is from before the last feed."""
        return self._cycles, self._levels

    def at(self, cycles: NDArray[np.int64]) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
        """Return the line's level at some cycles, and since which cycle it has had that level."""
        index = np.maximum(np.searchsorted(self._cycles, cycles, side="right") - 1, 0)
        return self._levels[index], self._cycles[index]


class Stepper(Switch):
    """The driver and its motor; as a `Switch`, it is the pin at ENABLE.

    position -- the motor's, in steps; violations -- number of edges closer together than the
    driver's data sheet allows; missed -- steps that came while the driver was not enabled.
    """

    def __init__(self, avr: Avr, board: Board, output: StepperOutput) -> None:
        super().__init__(avr, board, output.enable, output.enable_active)
        self._clock_hz = avr.clock_hz
        self._steps_per_mm = output.steps_per_mm
        self._timing = DRV8825
        names = [board.pins[name].port_name for name in (output.step, output.direction)]
        for name in names:
            avr.pins.pull(name, "low")  # the driver's own resistor
        step, direction = (avr.pins.watch(name) for name in names)
        self._step, self._direction = _Line(step, False), _Line(direction, False)
        self.log_edges()
        self._enable = _Line(self.number, self._inactive == "high")
        self._steps: list[NDArray[Any]] = [np.zeros(0, STEP)]
        self._last = np.zeros(0, np.int64)
        self._rises = 0
        self.position = 0
        self._reported = 0
        self.violations = 0
        self.missed = 0

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Process pin changes (PIN_EVENT)."""
        del sent
        self._rises = self._avr.pins.rises(self._step.number)
        for line in (self._step, self._direction, self._enable):
            line.feed(pins)
        self._judge_widths()
        cycles, levels = self._step.edges
        self._take(cycles[1:][levels[1:]])

    def _judge_widths(self) -> None:
        cycles, levels = self._step.edges
        widths = np.diff(cycles) / self._clock_hz
        least = np.where(levels[:-1], self._timing.high_s, self._timing.low_s)
        self.violations += int((widths < least).sum())

    def _judge_hold(self, rising: NDArray[np.int64]) -> None:
        rising = np.concatenate((self._last, rising))
        self._last = rising[-1:]
        turned = self._direction.edges[0][1:]
        before = np.searchsorted(rising, turned, side="right") - 1
        held = turned[before >= 0] - rising[before[before >= 0]]
        self.violations += int((held < self._timing.hold_s * self._clock_hz).sum())

    def _take(self, rising: NDArray[np.int64]) -> None:
        forward, since = self._direction.at(rising)
        enabled_level, enabled_since = self._enable.at(rising)
        on = enabled_level == (self.active == "high")
        setup = self._timing.setup_s * self._clock_hz
        early = (rising - since < setup) | (on & (rising - enabled_since < setup))
        self.violations += int((early & (rising >= setup)).sum())
        self._judge_hold(rising)
        steps = np.zeros(len(rising), STEP)
        steps["cycle"] = rising
        steps["way"] = np.where(on, np.where(forward, 1, -1), 0)
        self._steps.append(steps)
        self.position += int(steps["way"].sum())
        self.missed += int((~on).sum())

    @property
    def steps(self) -> NDArray[Any]:
        """Every step so far (STEP records)."""
        self._steps = [np.concatenate(self._steps)]
        return self._steps[0]

    @property
    def waits(self) -> bool:
        """Whether rising edges of STEP have come since the last `feed`."""
        return self._avr.pins.rises(self._step.number) != self._rises

    def travel_mm(self) -> float:
        """Return the feed since the last call, mm; backward is negative."""
        travel, self._reported = self.position - self._reported, self.position
        return travel / self._steps_per_mm


def attach(avr: Avr, board: Board, output: StepperOutput) -> Stepper:
    """Connect the driver to its pins, with the board's resistor that holds it off."""
    return Stepper(avr, board, output)
