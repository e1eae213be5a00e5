"""Whether nothing heats, and a fault comes, when nothing proves that the fan turns: to the tick.

From docs/control.md, "Proof of a fan"; the lines are those of world.c.
"""

from collections.abc import Iterator
from itertools import chain
from math import ceil, floor
from random import Random

from host_gate import COLD_C, LONG, Running

from heatwright.sim.host import Host
from heatwright.sim.host.parts import healthy_line, looks_of
from heatwright.spec import Proof, proofs

PROVES, TORN, SHORTED = 0, 1, 2
FAN_STOPPED = 28
COURSES = 30
TWO_BYTES = 1 << 16
Part = tuple[int, int]
"""What is on the line, and for how many ticks."""


def proof_problem(host: Host) -> str:
    """Say the first thing that is wrong; empty if nothing."""
    fans = proofs(host.build.controller)
    if not fans:
        return ""
    ((fan, proof),) = fans.items()
    watched = _Watched(host, fan, proof)
    courses = (each for parts in watched.courses() for each in watched.problems(parts))
    found = next(chain(courses, watched.lasting()), "")
    host.world.proof_line = PROVES
    return found


class _Model:
    """The watch of a proof, a tick at a time."""

    def __init__(self, proof: Proof, healthy: int, looks: int) -> None:
        self._fan, self._healthy, self._looks_of_tick = proof.tachometer, healthy, looks
        self._within_ticks = floor(100 * proof.within_s + 1e-6)
        self._looks = self._pulses = self._ticks = self._still = 0
        self._high = self._turns = self.found = False
        self.window = 0
        if self._fan:  # its limits are the default ones
            slow_hz, fast_hz = (self._fan.speed_rpm * self._fan.pulses * x / 60 for x in (0.5, 1.5))
            self.window = ceil(16 / slow_hz * 100 - 1e-6)
            self._least = floor(slow_hz * self.window / 100 + 1e-6)
            self._most = ceil(fast_hz * self.window / 100 - 1e-6)
            for _ in range(self.window):
                self.tick(PROVES)

    def tick(self, line: int) -> bool:
        """Return whether it is proved that the fan turns."""
        for _ in range(self._looks_of_tick):
            self._looks += 1
            high = self._is_high(line)
            self._pulses += high and not self._high
            self._high = high
        turns = self._counted() if self._fan else not self._high
        self._still = 0 if turns else self._still + 1
        self.found = self.found or self._still >= self._within_ticks
        return turns

    def _is_high(self, line: int) -> bool:
        line = line or self._healthy
        return line == TORN if line <= SHORTED else self._looks % line >= (line + 1) // 2

    def _counted(self) -> bool:
        self._ticks += 1
        if self._ticks == self.window:
            self._turns = self._least <= self._pulses <= self._most
            self._ticks = self._pulses = 0
        return self._turns


class _Watched(Running):
    """A loop that asks for full power, whatever its algorithm wants."""

    def __init__(self, host: Host, fan: str, proof: Proof) -> None:
        super().__init__(host)
        self._proof, controller = proof, host.build.controller
        self._healthy, self._looks = healthy_line(controller, fan), looks_of(controller)
        self._put = getattr(host.library, f"output_{self.parts.heater}_set")

    def courses(self) -> Iterator[list[Part]]:
        """Lines that stand for a tick, and for as long as may just be, or just not; pulses as many
        as may just be, or just not; some of all kinds."""
        within = floor(100 * self._proof.within_s + 1e-6)
        for line in (TORN, SHORTED):
            for ticks in (1, within - 1, within, within + 1, 2 * within):
                yield [(PROVES, 5), (line, ticks), (PROVES, 200)]
            yield [(line, within - 1), (PROVES, 200)] * 2
        window = _Model(self._proof, self._healthy, self._looks).window
        for pulses in (15, 16, 17, 48, 49, 50) if window else ():  # one in a tick
            for line in (TORN, SHORTED):
                yield [(10, pulses), (line, window - pulses)] * 3
        yield [(3, 200), (4, 200)]  # more than a byte can count
        random = Random(2)  # noqa: S311 - no secret
        for _ in range(COURSES):
            yield [(random.choice((0, 0, 1, 2, 4, 20, 27, 48, 62)), random.randint(1, 200))
                   for _ in range(6)]  # fmt: skip

    def problems(self, parts: list[Part]) -> Iterator[str]:
        model = _Model(self._proof, self._healthy, self._looks)
        self.host.world.proof_line = PROVES
        self.run_at(COLD_C)
        for _ in range(int(self.host.world.ticks)):
            model.tick(PROVES)
        for _ in range(self.window_ticks):
            self._tick(model, PROVES)
        latched = 0
        for number, (line, ticks) in enumerate(parts):
            for tick in range(ticks):
                turns, heats = self._tick(model, line)
                if heats != (turns and not latched):
                    yield f"{parts}, part {number}, tick {tick}: it heats: {heats}"
                if model.found and not self.host.world.ticks % self.period_ticks:
                    latched = FAN_STOPPED
                code = int(self.host.library.fault.code)
                if code != latched:
                    yield f"{parts}, part {number}, tick {tick}: fault {code}, not {latched}"
                if latched:
                    yield from self._goes_by()
                    return

    def _goes_by(self) -> Iterator[str]:
        """Whoever acknowledges is told again while it lasts, and then no more."""
        for line, code in ((TORN, FAN_STOPPED), (PROVES, 0)):
            self.host.world.proof_line = line
            self.ticks(LONG)
            self.library.host_acknowledge()
            self.ticks(2 * self.period_ticks)
            if int(self.library.fault.code) != code:
                yield f"acknowledged with line {line}: fault {self.library.fault.code}, not {code}"

    def lasting(self) -> Iterator[str]:
        """For more ticks than two bytes can count."""
        self.run_at(COLD_C)
        self.host.world.proof_line = TORN
        self.ticks(TWO_BYTES + self.period_ticks - TWO_BYTES % self.period_ticks)
        self.library.host_acknowledge()
        self.ticks(self.period_ticks)
        if int(self.library.fault.code) != FAN_STOPPED:
            yield f"after {self.host.world.ticks} ticks: fault {self.library.fault.code}"

    def _tick(self, model: _Model, line: int) -> tuple[bool, bool]:
        self._put(100.0)
        self.host.world.proof_line = line
        before = self.host.world.heater_counts
        self.library.host_tick()
        return model.tick(line), bool(self.host.world.heater_counts != before)
