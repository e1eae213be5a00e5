"""The reference models' way through courses, and how the host's way is compared with it."""

from collections.abc import Container, Iterator, Mapping
from math import nan
from typing import Any, NamedTuple

import numpy as np
from courses.host_commands import Commands
from numpy.typing import NDArray

from heatwright.sim.host.firmware import READY, STATE, Run
from heatwright.sim.host.parts import monitor_readings
from heatwright.sim.reference import Record, Reference
from heatwright.sim.reference.inputs import Gains, Orders
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.outputs.course import SteadyCourse, course_of
from heatwright.sim.reference.outputs.output import pwm_period
from heatwright.sim.reference.programs.state import ProgramState
from heatwright.sim.reference.protection.latch import Lockout
from heatwright.sim.reference.sensors.current import IdealSensor
from heatwright.spec import Controller, facts_of
from heatwright.spec.outputs import is_held

TICK_US = 10_000
HOST_READINGS, HOST_BAD, HOST_ONLY = 9, 16, 64  # bits of a row's `monitored`: see sim/host/world.h
TRIPPED_BY, TRIPPED_C = 6, 21.5
SLACK = 0.001  # for counts: the reference has shares of a time, which do not add up to the last bit


INPUT_OPEN = 31


class Restored(NamedTuple):
    """What is there after a reset, where that is not what the specification says."""

    program: ProgramState
    setpoint_c: Single
    gains: Gains | None
    critical_c: float  # only for loops where it is adjustable
    fault_code: int
    fault_c: Single
    fault_s: int


class Expected(NamedTuple):
    states: NDArray[Any]
    heater_counts: NDArray[np.float64]
    """Not numbers where the output decides by itself: nothing is expected then."""
    ticks: int
    cooler_ticks: float  # not a number where it decides by itself, either


def alone(controller: Controller, name: str) -> Controller:
    """A controller as one of its loops sees it: as if there were no other."""
    only = type(controller.loops)({name: controller.loops[name]})
    monitors = type(controller.loops)(facts_of(controller, name).monitored)
    return controller.model_copy(update={"loops": only, "monitors": monitors})


class Way:
    """The reference model of one loop, which does what the rows of a course say."""

    def __init__(self, controller: Controller, restored: Restored | None = None) -> None:
        ((name, self._loop),) = controller.loops.items()
        self._reference = Reference(controller, name)
        self._commands = Commands(controller, name, self._reference)
        output = controller.outputs[self._loop.heater]
        pwm = output.kind == "pwm"
        self._whole = pwm_period(controller, self._loop.heater).counts if pwm else 1
        # The timers of the host's build have no pulses: each tick counts a share.
        self._course = (
            SteadyCourse(self._whole) if pwm else course_of(controller, self._loop.heater)
        )
        self.period_us = round(self._loop.period_s * 1e6)
        self._time_s = 0
        self._record: Record | None = None
        self._takes_turn = self._closed = False
        self.now_us, self.on_counts, self.cooled_us = 0, 0.0, 0.0
        self._holds = is_held(output)
        self._holds = self._holds or controller.safety.relay is not None
        cooler = controller.outputs[self._loop.cooler] if self._loop.cooler else None
        self._cooler_holds = cooler is not None and is_held(cooler)
        self._holds = self._holds or self._cooler_holds  # the heater waits for it
        lost_s = self._loop.protection.master_lost_after_s
        self._silence_ticks = None if lost_s is None else round(lost_s * 100)
        self._monitors = {each: monitor_readings(controller, each) for each in controller.monitors}
        self._heard = dict.fromkeys(self._monitors, 0)
        self._current = getattr(output, "current", None)
        if self._current is not None:
            sensor = controller.sensors[self._current.sensor]
            self._sensor, self._taken = IdealSensor(sensor, controller.board), 0
            self._due_a = output.power_w / output.supply_v / 100
        self._was_open = False
        self._inputs = list(controller.safety.inputs.values())
        self._lockout = Lockout(controller)
        self._locks_out = controller.lockout is not None
        if restored is not None:
            self._lockout.count(restored.fault_code, 0)
            self._reference.restore(restored.fault_code, restored.fault_c)
            self._time_s = restored.fault_s
            self._commands.restore(*restored[:4])

    def take(self, number: int, row: Any) -> dict[str, Any]:
        self.give(number, row)
        return dict(zip(self.members, self.step(number, row), strict=True))

    def fill_current(self, row: Any) -> None:
        if self._current is None:
            return
        share = int(row["current_raw"])
        amperes = float(self._reference.duty_percent) * self._due_a * share / 100
        raw = -1 - share if share < 0 else self._sensor.read(amperes)[1]
        self._taken = row["current_raw"] = self._taken if row["current_status"] else raw

    def expected(
        self, inputs: NDArray[Any], kind: np.dtype[Any], tripped: Container[int] = ()
    ) -> Expected:
        return expected({"": self}, {"": inputs}, {"": kind}, tripped)[""]

    def advance(self, to_us: int) -> None:
        """Let heater and cooler go on as they are."""
        if self._takes_turn:  # from the cooler: whatever is due, the first tick is off
            self._course.advance(self.now_us + TICK_US)
            self._takes_turn = False
        on_us = self._course.advance(to_us)
        if not self._closed:
            self.on_counts += nan if self._holds else on_us * self._whole / TICK_US
        cooled_us = (to_us - self.now_us) * self._reference.cooling
        self.cooled_us += nan if self._cooler_holds else cooled_us
        self.now_us = to_us

    @property
    def members(self) -> list[str]:
        told = [STATE if self._commands.switched else READY] * self._commands.commanded
        own = ["fault.time_s", *["fault.trips"] * self._locks_out]
        return [*(name for name, _ in self._reference.members), *own, *told]

    def trip_and_acknowledge(self) -> None:
        """Between two steps, faster than either sees it."""
        if not self._reference.fault_code:
            self._latch(TRIPPED_BY, Single(TRIPPED_C))
        self.acknowledge()

    def acknowledge(self) -> None:
        """A loop that people or hosts command keeps its gate closed until its next step."""
        self._lockout.trips = 0  # a person at the machine
        self._commands.acknowledge()
        self._closed = self._closed and self._commands.commanded

    def tell(self, ways: Mapping[str, "Way"]) -> None:
        code, celsius = self._reference.fault_code, self._reference.fault_temperature_c
        for way in ways.values() if code else ():
            if not way._reference.fault_code:
                way._latch(code, celsius)

    def _latch(self, code: int, celsius: Single) -> None:
        self._reference.restore(code, celsius)
        self._commands.see_fault()
        self._note_fault()

    def _note_fault(self) -> None:
        self._time_s, self._closed = self.now_us // 1_000_000, True
        self._lockout.count(self._reference.fault_code, self.now_us)

    def give(
        self, number: int, row: Any, ways: Mapping[str, "Way"] | None = None
    ) -> tuple[bool, bool]:
        """Acknowledge and command, at once after the last step; a stop does not wait for one.
        `ways`: of all loops, where there are others, too. Return whether the command and the order
        are taken."""
        self.now_us = number * self.period_us
        ways = ways or {"": self}
        for way in ways.values() if row["acknowledge"] else ():
            way.acknowledge()
        code = self._reference.fault_code
        taken = self._commands.give(row)
        for way in ways.values() if self._commands.is_tunable else ():
            if way is not self:
                way._commands.share(row)
        if self._reference.fault_code != code:
            self._note_fault()
            self.tell(ways)
        self._closed = self._closed or self._commands.has_closed or bool(row["open_inputs"])
        return taken

    def tells(self) -> bool | None:
        """Whether the loop says now that it is ready, or on, if it is switched."""
        return self._commands.tells(self._record)

    def step(self, number: int, row: Any) -> tuple[Any, ...]:
        self.now_us = (number + 1) * self.period_us
        reference, commands = self._reference, self._commands
        code, cooled = reference.fault_code, reference.cooling
        reading = int(row["reading_status"]), int(row["reading_raw"])
        record = reference.step(*reading, commands.setpoint_c(row), orders=self._orders(row))
        self._record = record
        self._was_open = bool(row["open_inputs"])
        self._takes_turn = bool(cooled and not reference.cooling)
        commands.after_step()
        self._course.apply(reference.output.counts)
        self._closed = bool(record["fault.code"])
        if record["fault.code"] != code:
            self._note_fault()
        self._lockout.age(self.now_us - TICK_US)
        own = (self._time_s, *[self._lockout.trips] * self._locks_out)
        return (*record.values(), *own, *self._told(record))

    def _orders(self, row: Any) -> Orders:
        """What the row says; a period is longer than a contact has to be open, or closed again."""
        silence, mask = self._silence_ticks, int(row["open_inputs"])
        trips = any(each.trips and mask >> number & 1 for number, each in enumerate(self._inputs))
        return self._commands.orders._replace(
            monitors=self._monitored(int(row["monitored"])), current_raw=int(row["current_raw"]),
            paused=int(mask != 0 or self._was_open), watch_fault=INPUT_OPEN * trips,
            master_lost=silence is not None and int(row["silent_ticks"]) >= silence,
        )  # fmt: skip

    def _monitored(self, given: int) -> dict[str, tuple[int, int]]:
        """What each monitor reads; a failed reading leaves the code as it was."""
        only, given = divmod(given, HOST_ONLY)
        found = {}
        for number, (name, raws) in enumerate(self._monitors.items(), 1):
            what = given if only in {0, number} else 0
            if what < HOST_READINGS:
                self._heard[name] = raws[what]
            found[name] = max(0, what - HOST_BAD), self._heard[name]
        return found

    def _told(self, record: Record) -> list[int | bool]:
        if not self._commands.commanded:
            return []
        tell = self._commands.state if self._commands.switched else self._commands.is_ready
        return [tell(record)]


def ways_of(controller: Controller) -> dict[str, Way]:
    return {name: Way(alone(controller, name)) for name in controller.loops}


def _steps(
    ways: Mapping[str, Way], inputs: Mapping[str, NDArray[Any]], tripped: Container[int] = ()
) -> Iterator[tuple[str, Way, int]]:
    """Go through the courses of all loops at once; whoever is told of a step does it. Steps of one
    time come in the order of the loops, and then what their next rows say."""
    times_us = {0}
    for name, way in ways.items():
        times_us |= {way.period_us * (number + 1) for number in range(len(inputs[name]))}
    for time_us in sorted(times_us):
        due = [
            (name, way, time_us // way.period_us)
            for name, way in ways.items()
            if time_us % way.period_us == 0 and time_us // way.period_us <= len(inputs[name])
        ]
        for way in ways.values():
            way.advance(time_us)
        for name, way, number in due:
            if number:
                yield name, way, number - 1
                way.tell(ways)
        for name, way, number in due:
            if number < len(inputs[name]):
                for each in ways.values() if number in tripped else ():
                    each.trip_and_acknowledge()
                way.give(number, inputs[name][number], ways)


def fill_currents(ways: Mapping[str, Way], inputs: Mapping[str, NDArray[Any]]) -> None:
    """Make currents of what the rows say: per cent of what is due, or -1 - codes."""
    for name, way, number in _steps(ways, inputs):
        way.fill_current(inputs[name][number])
        way.step(number, inputs[name][number])


def expected(
    ways: Mapping[str, Way],
    inputs: Mapping[str, NDArray[Any]],
    kinds: Mapping[str, np.dtype[Any]],
    tripped: Container[int] = (),
) -> dict[str, Expected]:
    """What `Host.run_all` should give: the state after each step, the heater's counts before it.
    `tripped`: the steps before which a fault is latched and acknowledged at once."""
    rows: dict[str, list[tuple[Any, ...]]] = {name: [] for name in ways}
    counts: dict[str, list[float]] = {name: [] for name in ways}
    for name, way, number in _steps(ways, inputs, tripped):
        counts[name].append(way.on_counts % 2**32)
        rows[name].append(way.step(number, inputs[name][number]))
    found = {}
    for name, way in ways.items():
        states = np.zeros(len(rows[name]), kinds[name])
        columns = zip(*rows[name], strict=True) if rows[name] else [()] * len(way.members)
        for member, column in zip(way.members, columns, strict=True):
            states[member] = column
        ticks = way.now_us // TICK_US, way.cooled_us / TICK_US
        found[name] = Expected(states, np.array(counts[name]), *ticks)
    return found


def first_difference(found: Run, wanted: Expected) -> str:
    """Name the first step after which the two differ, by whatever bit; empty if none."""
    counts = found.heater_counts, wanted.heater_counts
    beside = np.abs(counts[0] - counts[1]) > SLACK
    if found.states.tobytes() == wanted.states.tobytes() and not beside.any():
        return ""  # quickly, for it is so nearly always
    off = {"heater counts": (beside, *counts)}
    for member in found.states.dtype.names or ():
        ours, theirs = found.states[member].copy(), wanted.states[member].copy()
        off[member] = (_bits(ours) != _bits(theirs), ours, theirs)
    rows = {name: int(which.argmax()) for name, (which, *_) in off.items() if which.any()}
    if not rows:
        return ""
    name = min(rows, key=lambda each: rows[each])
    row, (_, ours, theirs) = rows[name], off[name]
    return f"after step {row + 1}, {name}: host {ours[row]!r}, reference {theirs[row]!r}"


def _bits(values: NDArray[Any]) -> NDArray[Any]:
    return values.view(f"u{values.dtype.itemsize}")
