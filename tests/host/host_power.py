"""Whether a loop answers to commands, orders and losses of power as the reference does. Commands
and orders are given many of them in a step. The power is cut between two steps: then a program goes
on, or not, as it should."""

from collections.abc import Callable, Iterator
from functools import cache
from math import nan
from random import Random
from typing import Any, NamedTuple

import host_specs
import numpy as np
from courses import host_stretches_commanded as commanded
from courses.host_courses import inputs_of, kinds_of, random_course, random_firing
from courses.host_reference import Expected, Restored, Way, first_difference
from courses.host_stretches import NO_GAINS, Stretch
from host_values import scale_of
from numpy.typing import NDArray

from heatwright.sim.host import Command, Host
from heatwright.sim.host.layout import declarations
from heatwright.sim.reference.inputs import Gains
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.programs import state as program
from heatwright.spec import Controller

COURSES = 8
STRETCHES = 12
MOST_AT_ONCE = 3
GIVEN = (
    *commanded.SWITCHED_ORDERS,
    *((Command.ENABLE, 0.0, NO_GAINS), (Command.DISABLE, 0.0, NO_GAINS)) * 3,
    *((Command.MAXIMUM, value, NO_GAINS) for value in commanded.CRITICAL_C),
)
ORDERS = (
    *commanded.PROGRAM_ORDERS,
    program.START,
    *(program.JUMP, program.RESUME, program.PAUSE, program.PAUSE) * 2,
)
"""Often of those that may wait for each other."""
ASKED = {Command.SET: "may_set", Command.ENABLE: "may_enable"}
"""Commands of switched loops of which one may ask before whether they will be taken."""


class Given(NamedTuple):
    row: NDArray[Any]
    taken: tuple[bool, bool]  # the command, and the order
    tells: bool | None
    state: dict[str, Any]  # after it, where a step follows


@cache
def _course(name: str, number: int) -> list[Given]:
    random, controller = Random(f"answers {number}"), host_specs.spec_of(name).controller  # noqa: S311
    way, found = Way(controller), []
    course = random_course(random, STRETCHES, kinds_of(controller))
    for step, row in enumerate(inputs_of(controller, course)):
        for _ in range(random.randint(0, MOST_AT_ONCE)):
            given = _drawn(row, random, controller)
            found.append(Given(np.array([given]), way.give(step, given), way.tells(), {}))
        taken, state = way.give(step, row), way.step(step, row)
        members = dict(zip(way.members, state, strict=True))
        found.append(Given(np.array([row]), taken, way.tells(), members))
    return found


def _drawn(row: Any, random: Random, controller: Controller) -> Any:
    given = row.copy()
    given["acknowledge"] = random.random() < 0.1
    given["command"], given["value"], given["gains"] = random.choice(GIVEN)
    given["order"] = random.choice(ORDERS) if controller.programs else 0
    given["argument"] = random.randint(0, commanded.PLACES)
    return given


def prepare_answers(name: str) -> None:
    for number in range(COURSES):
        _course(name, number)


def answers_problem(host: Host, name: str) -> str:
    numbers = range(COURSES)
    return next((problem for each in numbers if (problem := _problem(host, name, each))), "")


def _problem(host: Host, name: str, number: int) -> str:
    parts, library, world = host.build.parts, host.library, host.world
    ffi = declarations(host.build.project, parts)
    loop = f"loop_{parts.name}"
    tells = getattr(library, f"{loop}_is_enabled" if parts.switched else f"{loop}_is_ready")
    host.renew()
    for place, (row, taken, told, members) in enumerate(_course(name, number)):
        command, value = Command(row[0]["command"]), float(row[0]["value"])
        asked = ASKED.get(command) if parts.switched and not row[0]["acknowledge"] else None
        arguments = [value] * (command == Command.SET)
        may = getattr(library, f"{loop}_{asked}")(*arguments) if asked else taken[0]
        if members:
            state = host.run(row).states[0]
        else:
            library.host_set(0, ffi.from_buffer("struct host_input[]", row))
        found = (may, not world.refused, not world.order_refused, told if told is None else tells())
        wrong = [key for key, wanted in members.items() if state[key] != wanted]
        if wrong or found != (taken[0], *taken, told):
            when = f"course {number}, {place}, {command.name} {value}, order {row[0]['order']}"
            return f"{when}: {found}, not {(*taken, told)}; not those of the reference: {wrong}"
    return ""


FIRINGS = 80
BEGIN_C = 30.0
MOST_STRETCHES = 5
LONG = [Stretch("start", 14, 16), *[Stretch("follow", 14, 16)] * 8]
"""Longer than the time between two records."""
NOT_KEPT = ("rate_k_per_s", "waited", "waiting", "leap", "order", "argument")

State = dict[str, Any]
Check = Callable[[Host, str], Iterator[str]]


def power_problem(host: Host, name: str) -> str:
    checks: tuple[Check, ...] = (_edges, _asked, _interrupted, _cut, _edited, _senseless)
    return next((problem for check in checks for problem in check(host, name)), "")


def _firing(number: int) -> list[Stretch]:
    random = Random(f"power {number}")  # noqa: S311
    return LONG if number % 10 == 0 else random_firing(random, number % MOST_STRETCHES)


@cache
def _before(name: str) -> list[tuple[NDArray[Any], list[State]]]:
    """Inputs up to the cut, and the states that the reference then has."""
    controller = host_specs.spec_of(name).controller
    found = []
    for number in range(FIRINGS):
        inputs = commanded.ProgrammedWalk(controller).inputs(_firing(number))
        way = Way(controller)
        found.append((inputs, [way.take(place, row) for place, row in enumerate(inputs)]))
    return found


class _Noted:
    """What the EEPROM has of a course: as it was after the step that wished to save last."""

    def __init__(self, controller: Controller, states: list[State]) -> None:
        ((_, loop),) = controller.loops.items()
        assert controller.programs is not None
        every_ms = round(1000 * controller.programs.save_every_s)
        self._every = every_ms // round(1000 * loop.period_s)
        self._since = self.saves = 0
        self.record: State | None = None
        last = {f"program.{name}": 0 for name, _ in program.MEMBERS}
        for state in states:
            self._step(last, state)
            last = state

    def _step(self, last: State, now: State) -> None:
        order, active = now["program.order"], last["program.state"] != program.IDLE
        followed = ("program.state", "program.segment")
        changed = any(now[key] != last[key] for key in followed)
        self._since += 1
        due = (
            now["program.state"] in (program.RUNNING, program.RETURNING)
            and self._since >= self._every
        )
        self.saves += order == program.START and active  # acknowledged and started at once
        self.saves += order in (program.STOP, program.PAUSE)  # before the step that obeys
        if changed or due or order in (program.START, program.JUMP):
            self._since = 0
            self.saves += 1
            self.record = now


def _program_of(record: State | None, *, keeps: bool) -> program.ProgramState:
    """The state of a program after a reset, by docs/control.md, "Loss of power"."""
    if record is None:
        return program.ProgramState()
    if record["program.state"] == program.IDLE:
        return program.ProgramState(ended=record["program.ended"], number=record["program.number"])
    kept = {name: record[f"program.{name}"] for name, _ in program.MEMBERS if name not in NOT_KEPT}
    if kept["state"] not in (program.PAUSED, program.INTERRUPTED):
        kept["state"] = program.RESTORING
    return program.ProgramState(
        **{**kept, "before_c": record["program.before_c" if keeps else "temperature_c"]}
    )


def _keeps(host: Host) -> bool:
    assert host.build.controller.programs is not None
    return host.build.controller.programs.on_fault == "pause"


def _restored(host: Host, record: State | None) -> Restored:
    """What a reference has to know of the firmware's settings after a reset."""
    library = host.library
    settings, fault = library.settings, library.fault
    tunable, adjustable = host.build.parts.tunable, host.build.parts.adjustable
    gains = (settings.air_kp, settings.air_ki, settings.air_kd) if tunable else ()
    kept = Single(settings.air_setpoint_c), Gains(*map(Single, gains)) if gains else None
    critical_c = settings.air_maximum_c if adjustable else nan
    latched = fault.code, Single(fault.temperature_c), fault.time_s
    return Restored(_program_of(record, keeps=_keeps(host)), *kept, critical_c, *latched)


_AFTER: dict[str, tuple[NDArray[Any], Expected]] = {}


def _after(
    name: str, number: int, restored: Restored, kind: np.dtype[Any]
) -> tuple[NDArray[Any], Expected]:
    """A course after the cut, and what the reference makes of it; most mutants ask for the same."""
    key = f"{name} {number} {restored}"
    if key not in _AFTER:
        controller = host_specs.spec_of(name).controller
        course = [Stretch("come_back", 2 + number % 5, number), *_firing(-number)]
        inputs = commanded.ProgrammedWalk(controller, restored).inputs(course)
        _AFTER[key] = inputs, Way(controller, restored).expected(inputs, kind)
    return _AFTER[key]


def _cut(host: Host, name: str) -> Iterator[str]:
    controller = host_specs.spec_of(name).controller
    for number, (inputs, states) in enumerate(_before(name)):
        noted = _Noted(controller, states)
        host.renew()
        host.run(inputs)
        host.library.host_settle()
        if host.library.progress_saves() != noted.saves:
            yield f"course {number}: {host.library.progress_saves()} saves, not {noted.saves}"
        host.power_up()
        restored = _restored(host, noted.record)
        after, wanted = _after(name, number, restored, host.type)
        problem = first_difference(host.run(after), wanted)
        if problem:
            yield f"course {number}, after the cut, {problem}"


def _run(host: Host) -> None:
    host.renew()
    host.set_reading(0, scale_of(host.build.controller).code(BEGIN_C))
    host.step()
    host.order(program.START, 1)
    for _ in range(3):
        host.step()
    host.library.host_settle()


def _expect(host: Host, when: str, **wanted: int) -> Iterator[str]:
    for key, value in wanted.items():
        found = getattr(host.library.program, key)
        if found != value:
            yield f"{when}: {key} is {found}, not {value}"


def _edges(host: Host, _: str) -> Iterator[str]:
    """How far the temperature may have gone; a step of the sensor further is too far."""
    assert host.build.controller.programs is not None
    after, scale = host.build.controller.programs.after_power_loss, scale_of(host.build.controller)
    gone = scale.code(after.resume_within_k) - scale.code(0.0)
    state, ended = (
        (program.PAUSED, 0) if after.otherwise == "pause" else (program.IDLE, program.TOO_FAR)
    )
    for sign in (-1, 1):
        for further in (0, 1):
            _run(host)
            host.power_up()
            host.set_reading(0, scale.code(BEGIN_C) + sign * (gone + further))
            before = host.library.progress_saves()
            host.step()
            host.library.host_settle()
            if host.library.progress_saves() != before + 1:
                yield "what was decided is not saved"
            resumes = gone and not further
            wanted = {"state": program.RETURNING, "leap": 1, "ended": 0}
            wanted = wanted if resumes else {"state": state, "leap": 0, "ended": ended}
            yield from _expect(host, f"{sign * (gone + further)} steps away", **wanted)


def _asked(host: Host, _: str) -> Iterator[str]:
    """What was paused waits for the operator, and a stop does not wait for a reading."""
    _run(host)
    host.order(program.PAUSE)
    host.step()
    host.library.host_settle()
    host.power_up()
    for _ in range(2):
        yield from _expect(host, "paused", state=program.PAUSED, number=1, ended=0)
        host.step()
    for status in (0, 1):
        _run(host)
        host.power_up()
        host.set_reading(status, scale_of(host.build.controller).code(BEGIN_C))
        host.order(program.STOP)
        host.step()
        yield from _expect(host, "stopped", state=program.IDLE, ended=program.STOPPED)


def _interrupted(host: Host, _: str) -> Iterator[str]:
    """What a fault keeps is kept through losses of power, with the temperature from before it."""
    if not _keeps(host):
        return
    scale = scale_of(host.build.controller)
    hot_c = host.build.controller.loops["air"].protection.maximum_c
    for acknowledged in (False, True):
        _run(host)
        clock = host.library.program.clock
        host.set_reading(0, scale.code(hot_c))
        host.step()
        host.library.host_settle()
        if acknowledged:
            host.set_reading(0, scale.code(BEGIN_C))
            host.acknowledge()
        host.step()
        host.library.host_settle()
        for _ in range(2):
            wanted = {"state": program.INTERRUPTED, "clock": clock + 1, "ended": 0}
            yield from _expect(host, "interrupted", **wanted, before_c=BEGIN_C)
            host.power_up()
        host.set_reading(0, scale.code(BEGIN_C))
        host.step()
        host.acknowledge()
        host.order(program.RESUME)
        host.step()
        within = host.build.controller.programs.after_power_loss.resume_within_k
        yield from _expect(host, "resumed", state=program.RETURNING if within else program.PAUSED)


def _edited(host: Host, _: str) -> Iterator[str]:
    """Another program at its place cannot go on, and that is said until the next one begins."""
    library = host.library
    host.renew()
    yield from _expect(host, "blank", **{name: 0 for name, _ in program.MEMBERS})
    _run(host)
    edited = library.program_loaded()[0]
    edited.segment[1].amount += 1
    library.programs_write(1, library.program_loaded())
    library.host_settle()
    for _ in range(2):
        host.power_up()
        wanted = {name: 0 for name, _ in program.MEMBERS}
        wanted |= {"number": 1, "ended": program.POWER_UNREADABLE}
        yield from _expect(host, "edited", **wanted)
        library.host_settle()
    _run(host)
    library.programs_write(2, library.program_loaded())
    library.host_settle()
    host.power_up()
    yield from _expect(host, "another place edited", state=program.RESTORING, number=1)


def _senseless(host: Host, _: str) -> Iterator[str]:
    """A record that is whole, but cannot be of this machine, is not gone on with."""
    limits = host.build.controller.loops["air"].protection
    places: list[tuple[str, list[tuple[float, bool]]]] = [
        ("segment", [(0, False), (1, True), (6, True), (7, False)]),
        ("number", [(0, False), (8, False), (9, False), (1, True)]),
        ("state", [(program.RETURNING, True), (program.RESTORING, False), (6, False)]),
    ]
    edges = [(limits.minimum_c, True), (limits.maximum_c, True), (nan, False)]
    edges += [(limits.minimum_c - 1, False), (limits.maximum_c + 1, False)]
    places += [(key, edges) for key in ("first_c", "from_c", "setpoint_c")]
    for key, values in places:
        for value, goes_on in values:
            _run(host)
            setattr(host.library.program, key, value)
            yield from _saved(host, f"{key} {value}", goes_on=goes_on)
    for value, goes_on in edges:
        _run(host)
        host.library.loop_air.temperature_c = host.library.program.before_c = value
        yield from _saved(host, f"temperature {value}", goes_on=goes_on)
    _run(host)
    host.library.program.elapsed = 1000
    yield from _saved(host, "too far", goes_on=True)
    yield from _expect(host, "too far", elapsed=host.library.program.length)


def _saved(host: Host, when: str, *, goes_on: bool) -> Iterator[str]:
    host.library.progress_save()
    host.library.host_settle()
    host.power_up()
    state, ended = (program.RESTORING, 0) if goes_on else (program.IDLE, program.POWER_UNREADABLE)
    yield from _expect(host, when, state=state, ended=ended)
