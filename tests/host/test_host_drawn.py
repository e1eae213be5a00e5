"""Drawn controllers on the host are the reference bit for bit, whatever the language allows."""

from random import Random

import numpy as np
import pytest
from host_builds import build_of_spec
from host_control import STRETCHES, run_problem
from host_courses import inputs_of, kinds_of, random_course
from host_reference import Way, first_difference
from rig.controllers import drawings
from suite import SEED, amount

from heatwright.sim.host import Host
from heatwright.sim.reference.held import has_minimum
from heatwright.spec import DigitalOutput

COURSES = 4
OTHER_CODES = ("over", "leak")
"""Stretches whose codes are those of the current sensor of `host_specs`."""


@pytest.mark.parametrize("number", range(amount("host_drawn_controllers")))
def test_any_controller_on_the_host_is_the_reference(number: int) -> None:
    random = Random(f"host {SEED} {number}")  # noqa: S311 - no secret
    drawn = next(drawings(random, loops=(1,)))
    controller = drawn.spec.controller
    ((_, loop),) = controller.loops.items()
    cooler = controller.outputs[loop.cooler] if loop.cooler else None
    kinds = tuple(kind for kind in kinds_of(controller) if kind not in OTHER_CODES)
    host = Host(build_of_spec(drawn.spec))
    for _ in range(COURSES):
        inputs = inputs_of(controller, random_course(random, STRETCHES, kinds))
        wanted = Way(controller).expected(inputs, host.type)
        wanted = wanted._replace(heater_counts=wanted.heater_counts % 2**32)  # as the host's are
        if isinstance(cooler, DigitalOutput) and has_minimum(cooler):
            # It decides by itself when it ends, and the heater waits for it.
            host.erase()
            host.power_up()
            nothing = np.full(len(inputs), np.nan)
            states = wanted._replace(heater_counts=nothing)
            assert first_difference(host.run(inputs), states) == "", drawn
        else:
            assert run_problem(host, inputs, wanted) == "", drawn
    host.close()
