"""Whether a host build decides as the reference model does, over many fixed courses."""

from functools import cache
from random import Random
from typing import Any

import host_specs
from host_courses import inputs_of, random_course
from host_reference import Expected, expected, first_difference
from numpy.typing import NDArray

from heatwright.sim.host import Host
from heatwright.sim.host.firmware import HostHangs

COURSES = 100
STRETCHES = 14


@cache
def _fixed(name: str) -> list[tuple[NDArray[Any], Expected]]:
    controller = host_specs.spec_of(name).controller
    found = []
    for seed in range(COURSES):
        course = random_course(Random(seed), STRETCHES)  # noqa: S311
        inputs = inputs_of(controller.loops["air"], course)
        found.append((inputs, expected(controller, inputs)))
    return found


def control_problem(host: Host, name: str) -> str:
    """Say where the host differs from the reference; empty if nowhere."""
    for number, (inputs, wanted) in enumerate(_fixed(name)):
        host.erase()
        host.power_up()
        try:
            difference = first_difference(host.run(inputs), wanted)
        except HostHangs as problem:
            difference = str(problem)
        if difference:
            return f"course {number}, {difference}"
    return ""
