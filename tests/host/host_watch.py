"""Whether what is watched beside readings switches off, and trips, as it must: to the tick. Inputs
that are open, from docs/control.md, "Inputs"; a fan that has to prove that it turns; a heater's
current, which is watched and limited as in the reference, to the very limits; and which trips are
counted for the lock-out."""

from collections.abc import Iterator
from itertools import chain
from math import ceil, floor, inf, nan
from random import Random
from typing import Any

import numpy as np
from courses.host_stretches_commanded import current_of
from host_gate import COLD_C, LONG, Running
from host_values import MILD_C, begun_at, next_step
from numpy.typing import NDArray

from heatwright.sim.host import Host
from heatwright.sim.host.parts import healthy_line, looks_of
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.protection.limiter import HALF, TWO, Limiter
from heatwright.spec import Input, Proof, facts_of

Part = tuple[int, int]
"""What is on the line, or which inputs are open, by their bits; and for how many ticks."""


class _Watched(Running):
    """A loop that asks for full power, whatever its algorithm wants."""

    def goes_by(self, line: str, trips: int, code: int, periods: int) -> Iterator[str]:
        """Whoever acknowledges is told again, so many periods later, while a line trips."""
        for level, told in ((trips, code), (0, 0)):
            setattr(self.host.world, line, level)
            self.ticks(LONG)
            self.library.host_acknowledge()
            self.ticks(periods * self.period_ticks)
            if int(self.library.fault.code) != told:
                yield f"acknowledged, {line} {level}: fault {self.library.fault.code}, not {told}"


INPUT_OPEN = 31
INPUT_COURSES = 40
PATIENCE = 4  # periods after which a step has come


def inputs_problem(host: Host) -> str:
    inputs = list(host.build.controller.safety.inputs.values())
    if not inputs:
        return ""
    watched = _Opened(host, inputs)
    courses = (each for parts in watched.courses() for each in watched.problems(parts))
    found = next(courses, "")
    host.world.open_inputs = host.world.pull_ups_flip = 0
    return found


class _Inputs:
    """Gate and watch, a tick at a time; found -- what the next control step trips."""

    def __init__(self, inputs: list[Input]) -> None:
        self._ticks = [floor(100 * each.for_s + 1e-6) for each in inputs]
        self._trips = [each.trips for each in inputs]
        self._open = [0] * len(inputs)
        self.left, self.found, self.was_paused = 0, False, False

    def tick(self, mask: int) -> bool:
        heats = not mask and not self.left
        self.was_paused |= not heats
        self.left = max(self._ticks) if mask else max(0, self.left - 1)
        for number, most in enumerate(self._ticks):
            self._open[number] = self._open[number] + 1 if mask >> number & 1 else 0
            self.found |= self._trips[number] and self._open[number] >= most
        if self.found:
            self.left = max(self._ticks)
        return heats


class _Opened(_Watched):
    def __init__(self, host: Host, inputs: list[Input]) -> None:
        super().__init__(host)
        self._given = inputs

    def courses(self) -> Iterator[list[Part]]:
        """Open for a tick, and for as long as may just be, or just not; some of all kinds."""
        for number, each in enumerate(self._given):
            most = floor(100 * each.for_s + 1e-6)
            for ticks in (1, most - 1, most, most + 1, 2 * most, 300):
                yield [(0, 5), (1 << number, ticks), (0, 200)]
            yield [(1 << number, most - 1), (0, 1)] * 5 + [(0, 200)]
        random = Random(3)  # noqa: S311 - no secret
        kinds = (0, 0, *range(1 << len(self._given)))
        for _ in range(INPUT_COURSES):
            yield [(random.choice(kinds), random.choice((1, 2, 3, 4, 5, 6, 40))) for _ in range(9)]

    def problems(self, parts: list[Part]) -> Iterator[str]:
        model = _Inputs(self._given)
        self.run_at(COLD_C)
        self.host.world.pull_ups_flip = len(parts) % 2
        latched = 0
        for number, (mask, ticks) in enumerate(parts):
            for tick in range(ticks):
                at = f"{parts}, part {number}, tick {tick}"
                ended = model.found
                self.host.world.open_inputs = mask
                heats = self.full(1) > 0
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
                    tripping = sum(each.trips << bit for bit, each in enumerate(self._given))
                    yield from self.goes_by("open_inputs", tripping, INPUT_OPEN, PATIENCE)
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


PROVES, TORN, SHORTED = 0, 1, 2
FAN_STOPPED = 28
PROOF_COURSES = 30
TWO_BYTES = 1 << 16


def proof_problem(host: Host) -> str:
    fans = facts_of(host.build.controller).proofs
    if not fans:
        return ""
    ((fan, proof),) = fans.items()
    watched = _Proven(host, fan, proof)
    courses = (each for parts in watched.courses() for each in watched.problems(parts))
    found = next(chain(courses, watched.lasting()), "")
    host.world.proof_line = PROVES
    return found


class _Fan:
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


class _Proven(_Watched):
    def __init__(self, host: Host, fan: str, proof: Proof) -> None:
        super().__init__(host)
        self._proof, controller = proof, host.build.controller
        self._healthy, self._looks = healthy_line(controller, fan), looks_of(controller)

    def courses(self) -> Iterator[list[Part]]:
        """Lines that stand for a tick, and for as long as may just be, or just not; pulses as many
        as may just be, or just not; some of all kinds."""
        within = floor(100 * self._proof.within_s + 1e-6)
        for line in (TORN, SHORTED):
            for ticks in (1, within - 1, within, within + 1, 2 * within):
                yield [(PROVES, 5), (line, ticks), (PROVES, 200)]
            yield [(line, within - 1), (PROVES, 200)] * 2
        window = _Fan(self._proof, self._healthy, self._looks).window
        for pulses in (15, 16, 17, 48, 49, 50) if window else ():  # one in a tick
            for line in (TORN, SHORTED):
                yield [(10, pulses), (line, window - pulses)] * 3
        yield [(3, 200), (4, 200)]  # more than a byte can count
        random = Random(2)  # noqa: S311 - no secret
        for _ in range(PROOF_COURSES):
            yield [(random.choice((0, 0, 1, 2, 4, 20, 27, 48, 62)), random.randint(1, 200))
                   for _ in range(6)]  # fmt: skip

    def problems(self, parts: list[Part]) -> Iterator[str]:
        model = _Fan(self._proof, self._healthy, self._looks)
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
                    yield from self.goes_by("proof_line", TORN, FAN_STOPPED, 2)
                    return

    def lasting(self) -> Iterator[str]:
        """For more ticks than two bytes can count."""
        self.run_at(COLD_C)
        self.host.world.proof_line = TORN
        self.ticks(TWO_BYTES + self.period_ticks - TWO_BYTES % self.period_ticks)
        self.library.host_acknowledge()
        self.ticks(self.period_ticks)
        if int(self.library.fault.code) != FAN_STOPPED:
            yield f"after {self.host.world.ticks} ticks: fault {self.library.fault.code}"

    def _tick(self, model: _Fan, line: int) -> tuple[bool, bool]:
        self.host.world.proof_line = line
        heats = self.full(1) > 0
        return model.tick(line), heats


RAWS = 1024
LASTS = 60  # steps in which each pair stays: a limit rises to its end, and a fault would come
UPSETS = (nan, inf, 1e30)  # what a bit that flips in RAM may make of the limit, and what is no duty


def current_problem(host: Host) -> str:
    controller = host.build.controller
    ((name, loop),) = controller.loops.items()
    current = current_of(controller)
    if current is None:
        return ""
    limiter = Limiter(controller, loop)
    members = [name for name, _ in limiter.members]
    inputs = begun_at(host, MILD_C)
    sensor = controller.sensors[current.sensor]
    for applied, raw in at_limits(limiter, getattr(sensor, "oversample", 1)):
        inputs["current_raw"] = raw
        for step in range(LASTS):
            getattr(host.library, f"loop_{name}").duty_percent = applied
            row = next_step(host, inputs)
            limiter.measure(raw, applied)
            code = limiter.watch()
            wanted = [*limiter.values(), code]
            found = [row[f"current.{member}"] for member in members] + [row["fault.code"]]
            if found != wanted:
                return f"{applied} % at {raw}, step {step}: {found}, not {wanted}"
    return _upset(host, inputs, limiter) if "limit_percent" in members else ""


def _upset(host: Host, inputs: NDArray[Any], limiter: Limiter) -> str:
    """Say which wrong limit is not the right one again in the next step; empty if none."""
    parts = host.build.parts
    applied = Single(60)
    for upset in (None,) * LASTS + UPSETS:
        if upset is not None:
            getattr(host.library, f"current_{parts.heater}").limit_percent = upset
        getattr(host.library, f"loop_{parts.name}").duty_percent = applied
        row = next_step(host, inputs)
        limiter.measure(int(inputs["current_raw"][0]), applied)
        found = row["current.limit_percent"]
        if found != limiter.top_percent:
            return f"a limit of {upset} becomes {found}, not {limiter.top_percent}"
    return ""


def at_limits(limiter: Limiter, scale: int) -> Iterator[tuple[Single, int]]:
    """Duties and sums of codes: a few of all, and all at which a rule is met to the last bit."""
    duties = [Single(each) for each in (0, 1.5, 25, 60, 99, 100)]
    yield from ((duty, raw * scale) for duty in duties for raw in (0, 1, 40, 200, 600, RAWS - 1))
    yield from ((duty, 0) for duty in at(TWO * limiter.idle_a, limiter.amperes_per_percent))
    for raw in range(0, RAWS * scale, 7):
        amperes = limiter.amperes_of(raw)
        for duty in at(TWO * amperes, limiter.amperes_per_percent):
            if HALF * (duty * limiter.amperes_per_percent) == amperes:
                yield duty, raw


def at(due_a: Single, per_percent: Single) -> list[Single]:
    """The duty up to 100 % that makes a current due, to the last bit, if there is one."""
    near = Single(due_a / per_percent)
    tried = (near, np.nextafter(near, Single(0)), np.nextafter(near, Single(200)))
    return [duty for duty in tried if duty <= 100 and duty * per_percent == due_a][:1]


HOT, MEMORY_DAMAGED = 6, 29
UNCOUNTED = (14, 15, 16, 19, 23, 30)
"""Those of the controller, its supply, its host, and who has forgotten it."""


def _without_fault(host: Host) -> Any:
    host.power_up()
    host.library.host_acknowledge()
    return host.library


def restored_problem(host: Host) -> str:
    """Say whether a processor that jumps to where the start restores a fault clears the latch."""
    library = _without_fault(host)
    library.fault_trip(HOT, 0.0)
    library.fault_restore([{"code": 0}])
    library.fault_judge(True, 0.0)
    code = int(library.fault.code)
    return "" if code == MEMORY_DAMAGED else f"nothing restored over {HOT} leaves {code} latched"


def lockout_problem(host: Host) -> str:
    controller = host.build.controller
    lockout = controller.lockout
    if lockout is None:
        return ""
    for rule in facts_of(controller).rules:
        library = _without_fault(host)
        library.fault.trips = 0
        library.fault_trip(rule.code, 0.0)
        if library.fault.trips != (rule.code not in UNCOUNTED):
            return f"{rule.id}: {library.fault.trips} trips are counted"
    for missing in (1, 0):
        library = _without_fault(host)
        library.fault.trips = max(0, lockout.trips - missing - 1)
        library.fault_trip(HOT, 0.0)
        if library.fault_is_locked() != (library.fault.trips == lockout.trips):
            return f"{library.fault.trips} trips of {lockout.trips} lock out, or do not"
    return ""
