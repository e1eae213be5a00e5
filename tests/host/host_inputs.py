"""Whether nothing heats while an input is open, and a fault comes of those that trip: to the tick.

From docs/control.md, "Inputs".
"""

from collections.abc import Iterator
from math import floor
from random import Random

from host_gate import COLD_C, LONG, Running

from heatwright.sim.host import Host
from heatwright.spec import Input

INPUT_OPEN = 31
COURSES = 40
PATIENCE = 4
"""Periods after which a step has come."""
Part = tuple[int, int]
"""Which inputs are open, by their bits, and for how many ticks."""


def inputs_problem(host: Host) -> str:
    """Say the first thing that is wrong; empty if nothing."""
    inputs = list(host.build.controller.safety.inputs.values())
    if not inputs:
        return ""
    watched = _Watched(host, inputs)
    courses = (each for parts in watched.courses() for each in watched.problems(parts))
    found = next(courses, "")
    host.world.open_inputs = host.world.pull_ups_flip = 0
    return found


class _Model:
    """Gate and watch, a tick at a time; found -- what the next control step trips."""

    def __init__(self, inputs: list[Input]) -> None:
        self._ticks = [floor(100 * each.for_s + 1e-6) for each in inputs]
        self._trips = [each.trips for each in inputs]
        self._open = [0] * len(inputs)
        self.left, self.found, self.was_paused = 0, False, False

    def tick(self, mask: int) -> bool:
        """Return whether it may heat."""
        heats = not mask and not self.left
        self.was_paused |= not heats
        self.left = max(self._ticks) if mask else max(0, self.left - 1)
        for number, most in enumerate(self._ticks):
            self._open[number] = self._open[number] + 1 if mask >> number & 1 else 0
            self.found |= self._trips[number] and self._open[number] >= most
        if self.found:
            self.left = max(self._ticks)
        return heats


class _Watched(Running):
    """A loop that asks for full power, whatever its algorithm wants."""

    def __init__(self, host: Host, inputs: list[Input]) -> None:
        super().__init__(host)
        self._given = inputs
        self._put = getattr(host.library, f"output_{self.parts.heater}_set")

    def courses(self) -> Iterator[list[Part]]:
        """Open for a tick, and for as long as may just be, or just not; some of all kinds."""
        for number, each in enumerate(self._given):
            most = floor(100 * each.for_s + 1e-6)
            for ticks in (1, most - 1, most, most + 1, 2 * most, 300):
                yield [(0, 5), (1 << number, ticks), (0, 200)]
            yield [(1 << number, most - 1), (0, 1)] * 5 + [(0, 200)]
        random = Random(3)  # noqa: S311 - no secret
        kinds = (0, 0, *range(1 << len(self._given)))
        for _ in range(COURSES):
            yield [(random.choice(kinds), random.choice((1, 2, 3, 4, 5, 6, 40))) for _ in range(9)]

    def problems(self, parts: list[Part]) -> Iterator[str]:
        model = _Model(self._given)
        self.run_at(COLD_C)
        self.host.world.pull_ups_flip = len(parts) % 2
        latched = 0
        for number, (mask, ticks) in enumerate(parts):
            for tick in range(ticks):
                at = f"{parts}, part {number}, tick {tick}"
                before, ended = int(self.host.world.heater_counts), model.found
                self.host.world.open_inputs = mask
                self._put(100.0)
                self.library.host_tick()
                heats = int(self.host.world.heater_counts) != before
                may = model.tick(mask) and not latched
                if heats and not may:
                    yield f"{at}: it heats"
                if may and not heats and not self.parts.cooler and not self._holds():
                    yield f"{at}: it does not heat"
                if (ended or model.found) and not self.host.world.ticks % self.period_ticks:
                    latched = INPUT_OPEN
                if int(self.library.fault.code) != latched:
                    yield f"{at}: fault {self.library.fault.code}, not {latched}"
                if latched:
                    yield from self._goes_by()
                    return
                if not self.host.world.ticks % self.period_ticks:
                    paused = bool(getattr(self.library, f"loop_{self.parts.name}").paused)
                    if paused != model.was_paused:
                        yield f"{at}: the step is paused: {paused}"
                    model.was_paused = False

    def _holds(self) -> bool:
        """Whether the heater's own shortest times may keep it off."""
        output = self.host.build.controller.outputs[self.parts.heater]
        return bool(getattr(output, "minimum_off_s", 0) or getattr(output, "window_s", 0))

    def _goes_by(self) -> Iterator[str]:
        """Whoever acknowledges is told again while it lasts, and then no more."""
        tripping = sum(each.trips << number for number, each in enumerate(self._given))
        for mask, code in ((tripping, INPUT_OPEN), (0, 0)):
            self.host.world.open_inputs = mask
            self.ticks(LONG)
            self.library.host_acknowledge()
            self.ticks(PATIENCE * self.period_ticks)
            if int(self.library.fault.code) != code:
                yield f"acknowledged with {mask} open: fault {self.library.fault.code}, not {code}"
