"""Whether a loop answers to commands and orders as the reference does, many of them in a step."""

from functools import cache
from random import Random
from typing import Any, NamedTuple

import host_specs
import numpy as np
from courses.host_courses import inputs_of, kinds_of, random_course
from courses.host_reference import Way
from courses.host_stretches import NO_GAINS
from courses.host_stretches_commanded import CRITICAL_C, SWITCHED_ORDERS
from courses.host_stretches_programmed import ORDERS as ALL_ORDERS
from courses.host_stretches_programmed import PLACES
from numpy.typing import NDArray

from heatwright.sim.host import Command, Host
from heatwright.sim.host.layout import declarations
from heatwright.sim.reference.programs.state import JUMP, PAUSE, RESUME, START
from heatwright.spec import Controller

COURSES = 8
STRETCHES = 12
MOST_AT_ONCE = 3
GIVEN = (
    *SWITCHED_ORDERS,
    *((Command.ENABLE, 0.0, NO_GAINS), (Command.DISABLE, 0.0, NO_GAINS)) * 3,
    *((Command.MAXIMUM, value, NO_GAINS) for value in CRITICAL_C),
)
ORDERS = (*ALL_ORDERS, START, *(JUMP, RESUME, PAUSE, PAUSE) * 2)
"""Often of those that may wait for each other."""
ASKED = {Command.SET: "may_set", Command.ENABLE: "may_enable"}
"""Commands of switched loops of which one may ask before whether they will be taken."""


class Given(NamedTuple):
    row: NDArray[Any]
    taken: tuple[bool, bool]
    """The command, and the order."""
    tells: bool | None
    state: dict[str, Any]
    """After it, where a step follows."""


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
    given["argument"] = random.randint(0, PLACES)
    return given


def prepare_answers(name: str) -> None:
    """Let the reference take all courses."""
    for number in range(COURSES):
        _course(name, number)


def answers_problem(host: Host, name: str) -> str:
    """Say the first thing that is wrong; empty if nothing."""
    numbers = range(COURSES)
    return next((problem for each in numbers if (problem := _problem(host, name, each))), "")


def _problem(host: Host, name: str, number: int) -> str:
    parts, library, world = host.build.parts, host.library, host.world
    ffi = declarations(host.build.project, parts)
    loop = f"loop_{parts.name}"
    tells = getattr(library, f"{loop}_is_enabled" if parts.switched else f"{loop}_is_ready")
    host.erase()
    host.power_up()
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
