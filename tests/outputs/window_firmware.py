"""Windows by themselves: a program that gives a time-proportional output what a test asks for."""

from collections.abc import Iterator

import numpy as np
from output_firmware import Board, Broken, controller_of, program

from heatwright.sim.outputs.switch import Switch
from heatwright.spec import TimeProportionalOutput

MAIN = """
#include "output_heater.h"

struct fault_state fault;
volatile uint8_t permitted = 1;
volatile float percent;
volatile uint8_t asked;

void fault_trip(uint8_t code, float temperature_c)
{
    fault.code = code;
    fault.temperature_c = temperature_c;
}

void gate_tick(void)
{
    output_heater_tick(permitted != 0);
}

int main(void)
{
    clock_start();
    sei();
    for (;;) {
        clock_wait();
        if (asked != 0) {
            asked = 0;
            output_heater_set(percent);
        }
    }
}
"""
TICK_S = 0.01
LATE_S = 0.004
"""Into a tick: all that it did is done."""


class WindowBoard(Board):
    """A board with one such output, run tick by tick."""

    def __init__(self, board: str, said: str, broken: Broken | None = None) -> None:
        outputs = {"heater": said}
        self.controller = controller_of(board, outputs)
        self.program = program(board, outputs, MAIN, "reset", broken=broken)
        super().__init__(self.program, self.controller)
        output = self.controller.outputs["heater"]
        assert isinstance(output, TimeProportionalOutput)
        self.output = output
        self.heater = Switch(self.avr, self.board, output.pin, output.active)
        self.avr.run(TICK_S + LATE_S)
        self.avr.pins.take()
        self.changes = 0
        self._last = self.avr.pins.level(self.heater.pin)

    def ask(self, percent: float) -> None:
        """Ask for a duty; the main loop takes it in the next tick, behind the interrupt."""
        self.put("percent", percent)
        self.put("asked", 1)

    def tick(self) -> bool:
        """Go on to just after the next tick; say whether it is on."""
        self.avr.run(TICK_S)
        events = self.avr.pins.take()
        levels = events[events["pin"] == self.heater.number]["state"] & 1
        self.changes += int(np.count_nonzero(np.diff(levels, prepend=self._last)))
        self._last = self.avr.pins.level(self.heater.pin)
        return self.heater.on


class Windows:
    """What such an output does, from the specification: windows counted in ticks."""

    def __init__(self, output: TimeProportionalOutput) -> None:
        self._output = output
        self._ticks = round(output.resolution_s / TICK_S)
        self._steps = round(output.window_s / output.resolution_s)
        self._asked: int | None = None
        self._on_steps = 0
        self._tick = 0

    def ask(self, percent: float) -> None:
        """Take over a duty between two ticks."""
        steps = int(percent * self._steps / 100 + 0.5)
        if steps < self._in_steps(self._output.minimum_on_s):
            steps = 0
        if steps > self._steps - self._in_steps(self._output.minimum_off_s):
            steps = self._steps
        self._asked = steps
        if steps == 0:
            self._on_steps = 0

    def _in_steps(self, seconds: float) -> int:
        return round(seconds / self._output.resolution_s)

    def tick(self) -> bool:
        """Say whether it is on from the next tick on."""
        if self._asked is None:
            return False
        if self._tick == 0:
            self._on_steps = self._asked
        step = self._tick // self._ticks
        self._tick = (self._tick + 1) % (self._steps * self._ticks)
        if self._output.distribution == "burst":
            return step < self._on_steps
        # The n-th pulse is at the first step that is not before n / on of the window.
        return any(step == -(-n * self._steps // self._on_steps) for n in range(self._on_steps))


def problem(bench: WindowBoard, duties: Iterator[tuple[float, int]]) -> str:
    """Say where a course of duties, each for some ticks, is not what it should be."""
    model, number, changes, last = Windows(bench.output), 0, bench.changes, bench.heater.on
    for percent, ticks in duties:
        bench.ask(percent)
        for late in range(ticks):
            seen, due = bench.tick(), model.tick()
            if seen != due:
                return f"tick {number}, {percent} %: {seen}, not {due}"
            changes, last = changes + (seen != last), seen
            number += 1
            if late == 0:
                model.ask(percent)
    if bench.changes != changes:
        return f"{bench.changes} changes of the pin, not {changes}"
    return ""


def closed_problem(bench: WindowBoard) -> str:
    """Say whether a closed gate, or an order for nothing, leaves it on."""
    for percent in (100.0, 60.0):
        bench.ask(percent)
        on = [bench.tick() for _ in range(300)]
        bench.put("permitted", 0)
        if not any(on) or any(bench.tick() for _ in range(300)):
            return "on with the gate closed"
        if not bench.heater.driven:
            return "not driven"
        bench.put("permitted", 1)
        if not any(bench.tick() for _ in range(300)):
            return "not on again"
        bench.ask(0.0)
        if bench.tick() and bench.tick():
            return "zero waits for the window's end"
        if any(bench.tick() for _ in range(300)):
            return "on at zero"
    return ""


__all__ = ["Broken", "WindowBoard", "closed_problem", "problem"]
