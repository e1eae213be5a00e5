"""Windows tick by tick: what a time-proportional output should do, and what it does."""

import random
from collections.abc import Iterator

from rig.outputs import LATE_S, TICK_S, OutputBoard, Wired, wired

from heatwright.sim.elf import Elf
from heatwright.spec import TimeProportionalOutput

BURST = "window: 1 s, resolution: 10 ms"
SHORT_LEFT_OUT = f"{BURST}, minimum_on: 50 ms, minimum_off: 100 ms"
SPREAD = "window: 2 s, resolution: 20 ms, distribution: spread"


def windows(window: str, active: str, board: str = "uno", pin: str = "D3") -> Wired:
    """Put such a heater on a board."""
    said = f"kind: time_proportional, pin: {pin}, active: {active}, power: 40 W, {window}"
    return wired(board, {"heater": said})


class WindowBoard(OutputBoard):
    """A board with one such output, run tick by tick."""

    def __init__(self, place: Wired, elf: Elf | None = None) -> None:
        super().__init__(place, elf)
        output = self.controller.outputs["heater"]
        assert isinstance(output, TimeProportionalOutput)
        self.output = output
        self.heater = self.outputs["heater"]
        self.avr.run(TICK_S + LATE_S)
        self.avr.pins.take()
        self.switched = 0
        self._last = self.heater.on

    def tick(self) -> bool:
        """Go on to just after the next tick; say whether it is on."""
        self.avr.run(TICK_S)
        for change in self.changes():
            self.switched += change.on != self._last
            self._last = change.on
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


def duties(seed: int, most_ticks: int, count: int) -> Iterator[tuple[float, int]]:
    """Draw duties, some at the ends, each for some time."""
    drawn = random.Random(seed)  # noqa: S311 - no secret
    for _ in range(count):
        percent = drawn.choice([0.0, 100.0, 1.0, 99.0, 50.0, drawn.uniform(0, 100)])
        yield percent, drawn.randint(1, most_ticks)


def problem(bench: WindowBoard, asked: Iterator[tuple[float, int]]) -> str:
    """Say where a course of duties, each for some ticks, is not what it should be."""
    model, number, due_switched, last = Windows(bench.output), 0, bench.switched, bench.heater.on
    for percent, ticks in asked:
        bench.ask("heater", percent)
        for late in range(ticks):
            seen, due = bench.tick(), model.tick()
            if seen != due:
                return f"tick {number}, {percent} %: {seen}, not {due}"
            due_switched, last = due_switched + (seen != last), seen
            number += 1
            if late == 0:
                model.ask(percent)
    if bench.switched != due_switched:
        return f"{bench.switched} changes of the pin, not {due_switched}"
    return ""


def closed_problem(bench: WindowBoard) -> str:
    """Say whether a closed gate, or an order for nothing, leaves it on."""
    for percent in (100.0, 60.0):
        bench.ask("heater", percent)
        on = [bench.tick() for _ in range(300)]
        bench.put("permitted", 0)
        if not any(on) or any(bench.tick() for _ in range(300)):
            return "on with the gate closed"
        if not bench.heater.driven:
            return "not driven"
        bench.put("permitted", 1)
        if not any(bench.tick() for _ in range(300)):
            return "not on again"
        bench.ask("heater", 0.0)
        if bench.tick() and bench.tick():
            return "zero waits for the window's end"
        if any(bench.tick() for _ in range(300)):
            return "on at zero"
    return ""


def whole_problem(place: Wired, elf: Elf | None = None) -> str:
    """Say what is wrong with windows; empty if nothing."""
    late = WindowBoard(place, elf)
    for _ in range(7):
        late.tick()  # the first window begins with the first duty, whenever that comes
    first = WindowBoard(place, elf)
    ticks = round(first.output.window_s / TICK_S)
    behind = [
        (30.0, ticks + 1),
        *((each, ticks) for each in (50.0, 2.0, 99.0, 4.0, 5.0, 6.0, 89.0, 90.0, 91.0, 40.0)),
    ]
    return (
        problem(first, iter(behind))  # each duty comes behind the first tick of a window
        or problem(late, duties(2, 400, 25))
        or closed_problem(WindowBoard(place, elf))
    )
