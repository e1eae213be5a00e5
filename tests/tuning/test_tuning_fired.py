"""Tuning a kiln: how far full power goes, for which temperature, and with the loop on."""

from itertools import islice

import pytest
from rig.specs import example

from heatwright.cli.ends import Refused
from heatwright.cli.tune.task import task_of
from heatwright.sim.tuning.process import at_full_power, process_of
from heatwright.sim.tuning.trial import at_setpoint

LOOP = "chamber"


def task(spec, at_c=None):
    return task_of(spec, None, at_c=at_c, lambda_s=None, tauc_s=None)


def test_a_linear_machine_ends_where_its_gain_says(chamber):
    process = process_of(chamber, "air")
    step_s = process.lags_s[0]
    (*_, (time_s, ends_c)) = islice(at_full_power(chamber, "air", step_s), 40)
    assert time_s == pytest.approx(40 * step_s)
    assert ends_c == pytest.approx(chamber.simulation.ambient_c + 100 * process.gain)


def test_a_kiln_ends_where_it_radiates_what_it_is_given():
    """Of the element's power each kelvin of the brick takes a part, and its fourth power one."""
    kiln = example("kiln").controller
    (*_, (_, ends_c)) = islice(at_full_power(kiln, LOOP, 200.0), 400)
    brick_k = ends_c - 484 * 0.5 + 273.15
    lost_w = (brick_k - 293.15) / 2.6 + 5.670374419e-8 * 0.005 * 0.3 * (brick_k**4 - 293.15**4)
    assert lost_w == pytest.approx(484, rel=1e-6)


def test_it_is_tuned_for_the_hottest_of_its_programs():
    found = task(example("kiln"))
    assert found.target_c == 800.0
    assert 600 < found.warm_s < 3600


def test_what_full_power_does_not_reach_is_refused():
    spec = example("kiln_uno")
    outputs = dict(spec.controller.outputs)
    outputs["element"] = outputs["element"].model_copy(update={"power_w": 100.0})
    weak = spec.controller.model_copy(update={"outputs": outputs})
    with pytest.raises(Refused, match="full power ends at"):
        task(spec._replace(controller=weak), at_c=600.0)


def test_what_people_switch_is_on_from_the_start():
    kiln = at_setpoint(example("kiln").controller, LOOP, 500.0).loops[LOOP]
    assert (kiln.starts, kiln.setpoint.initial_c) == ("enabled", 500.0)
    for name, loop in (("extruder", "nozzle"), ("fabricator", "nozzle")):
        controller = example(name).controller
        assert at_setpoint(controller, loop, 100.0) is controller
