"""The generated C, on the host: what each judge of the mutants holds of it, and the reference. The
specifications of the host build take every branch of the templates, both ways."""

import re
from collections import defaultdict
from functools import cache
from importlib.resources import files
from random import Random

import host_specs
import numpy as np
import pytest
from arena_host import judges_of
from courses.host_courses import inputs_of, kinds_of, random_inputs
from courses.host_reference import Way, expected, ways_of
from courses.host_stretches import Stretch
from host_control import STRETCHES, all_problem, run_problem
from host_specs import build_of_spec
from host_values import MOST_DECIMALS, code_problem, text_problem
from hypothesis import given, settings
from hypothesis import strategies as st
from jinja2 import Environment
from rig.controllers import drawings
from storage_host import Kept, Progresses
from storage_programs import Programs
from storage_settings import SettingsKept
from suite import SEED, amount

from heatwright.generator import plan_firmware
from heatwright.generator.plan.loop.features import FEATURES
from heatwright.generator.plan.loop.names import loop_names
from heatwright.generator.plan.loop.steps import always
from heatwright.generator.plan.source import Source
from heatwright.generator.render import names
from heatwright.sim.host import Host
from heatwright.sim.host.firmware import INPUT
from heatwright.sim.reference import Reference
from heatwright.spec import Spec, load_text

KEPT: dict[type[Kept], tuple[str, ...]] = {
    Programs: ("few", "many", "usual"),
    Progresses: ("few", "usual", "pausing"),
    SettingsKept: (
        "few", "typed", "usual", "switch_lead", "pid_hold", "tuned_hot", "switched_by_host",
        "tuned_by_master", "touched", "keyed_switch", "keyed_gains",
    ),
}  # fmt: skip
"""Machines with programs; loops without and with a stored setpoint, gains, types."""
JUDGED = [(name, judge) for name in host_specs.NAMES for judge in judges_of(name)]


@pytest.mark.parametrize(("name", "judge"), JUDGED)
def test_nothing_is_wrong(hosts, name, judge):
    assert judges_of(name, amount("host_courses"))[judge](hosts(name)) == ""


@pytest.mark.parametrize(
    ("kind", "name", "check"),
    [
        (kind, name, check)
        for kind, names in KEPT.items()
        for name in names
        for check in kind.checks
    ],
)
def test_what_is_kept_stands(hosts, kind, name, check):
    kept = kind(hosts(name))
    assert [*getattr(kept, check)(), *kept.beyond()] == []


@pytest.mark.parametrize("name", host_specs.NAMES)
def test_names_and_widths_are_those_of_the_reference(hosts, name):
    controller = host_specs.spec_of(name).controller
    members = dict(Reference(controller, next(iter(controller.loops))).members)
    state = hosts(name).type
    found = {member: state[member].str.lstrip("<|") for member in state.names}
    assert found.pop("fault.time_s") == "u4"  # for the log, of no effect
    counts = {"fault.trips": "u1"} if controller.lockout is not None else {}
    members |= counts  # of the controller, held to its model by heatwright.sim.judges.lockouts
    assert ("ready" in found) == (name in host_specs.HOSTED)
    assert ("state" in found) == (name in host_specs.SWITCHED)
    found.pop("ready", None)
    found.pop("state", None)
    assert found == members


def stretch(kinds):
    numbers = st.integers(1, 14), st.integers(-200, 200), st.integers(-1, 1)
    return st.builds(Stretch, st.sampled_from(kinds), *numbers, st.booleans())


@pytest.mark.parametrize("name", host_specs.NAMES)
@given(data=st.data())
@settings(max_examples=amount("host_drawn_courses"))
def test_equal_to_the_reference_bit_for_bit(hosts, name, data):
    controller = host_specs.spec_of(name).controller
    course = data.draw(st.lists(stretch(kinds_of(controller)), min_size=1, max_size=14))
    host = hosts(name)
    inputs = inputs_of(controller, course)
    assert run_problem(host, inputs, Way(controller).expected(inputs, host.type)) == ""


def test_one_step_at_a_time_is_the_same_as_many(hosts):
    host = hosts("pid_hold")
    inputs = np.zeros(4, INPUT)
    inputs["reading_status"] = 0, 2, 0, 0
    inputs["acknowledge"] = 0, 0, 0, 1
    inputs["reading_raw"] = 300, 300, 340, 2000
    inputs["setpoint_c"] = 40, 40, 40, 41
    host.renew()
    together = host.run(inputs).states
    host.renew()
    for row, wanted in zip(inputs, together, strict=True):
        host.set_reading(int(row["reading_status"]), int(row["reading_raw"]))
        host.set_setpoint(float(row["setpoint_c"]))
        if row["acknowledge"]:
            host.acknowledge()
        assert tuple(host.step().values()) == wanted.item()


ANY_NUMBER = st.one_of(st.floats(width=32), st.floats(-2e7, 2e7, width=32))


@given(value=ANY_NUMBER, decimals=st.integers(0, MOST_DECIMALS))
def test_any_number_is_rounded_half_away_from_zero_inside_its_text(hosts, value, decimals):
    assert text_problem(hosts("switch_lead"), value, decimals) == ""


@pytest.mark.parametrize("decimals", range(MOST_DECIMALS + 1))
def test_every_temperature_of_the_sensor_is_written_exactly(hosts, decimals):
    for raw in range(-(2**15), 2**15):
        assert code_problem(hosts("switch_lead"), raw, decimals) == ""


COURSES = 4


def loops_problem(spec: Spec, random: Random) -> str:
    """Say where the host build of a spec differs from the references of its loops; empty if
    nowhere."""
    controller, host = spec.controller, Host(build_of_spec(spec))
    problem = ""
    for _ in range(COURSES):
        inputs = random_inputs(controller, random, STRETCHES)
        wanted = expected(ways_of(controller), inputs, host.types)
        problem = problem or all_problem(host, inputs, wanted)
    host.close()
    return problem


@pytest.mark.parametrize("changed", [str, host_specs.in_other_order])
@pytest.mark.parametrize("name", host_specs.SEVERAL)
def test_loops_with_one_latch_are_the_references(name, changed) -> None:
    spec = load_text(changed(host_specs.SEVERAL[name]), f"{name}.yaml")
    assert loops_problem(spec, Random(f"host {SEED} {name}")) == ""  # noqa: S311 - no secret


@pytest.mark.parametrize("number", range(amount("host_drawn_controllers")))
def test_any_controller_on_the_host_is_the_reference(number: int) -> None:
    random = Random(f"host {SEED} {number}")  # noqa: S311 - no secret
    drawn = next(drawings(random, loops=((1,), (2, 3))[number % 2]))
    assert loops_problem(drawn.spec, random) == "", drawn


TEMPLATES = (
    "loop/step/cooler.c.j2", "loop/public/hosted.c.j2", "loop/public/hosted_mode.c.j2",
    "loop/public/ready.c.j2", "loop/public/regulates.c.j2", "loop/public/state.c.j2",
    "loop/public/switched.c.j2", "protection/current.c.j2", "protection/guard.c.j2",
    "programs/program.c.j2", "core/settings.c.j2", "protection/gate.c.j2", "protection/fault.c.j2",
    "algorithms/on_off.c.j2", "algorithms/lead.c.j2", "algorithms/pid.c.j2",
    "algorithms/three_position.c.j2", "algorithms/autotune.c.j2", "outputs/time_proportional.c.j2",
    "protection/proof.c.j2", "protection/proof.h.j2", "protection/inputs.c.j2",
    "protection/inputs.h.j2",
)  # fmt: skip
INCLUDED_BY = {"algorithms/lead.c.j2": "algorithms/three_position.c.j2"}
CONDITION = re.compile(r"^\s*//% if (.*)$", re.MULTILINE)


@cache
def planned():
    found = defaultdict(list)
    for name in host_specs.NAMES:
        for file in plan_firmware(host_specs.spec_of(name)).files:
            context = names(file.told)
            context["control"] = (context.get("loops") or [{}])[0]
            parts = *context.get("helpers", ()), *context.get("public", ())
            for template in (file.template, *parts):
                found[template].append(context)
    return found


@pytest.mark.parametrize("template", TEMPLATES)
def test_every_condition_is_true_once_and_false_once(template):
    text = files("heatwright.templates").joinpath(template).read_text(encoding="utf-8")
    for condition in set(CONDITION.findall(text)):
        evaluate = Environment(autoescape=True).compile_expression(condition)
        contexts = planned()[INCLUDED_BY.get(template, template)]
        found = {bool(evaluate(**context)) for context in contexts}
        assert found == {True, False}, condition


OPTIONAL = [
    each
    for each in FEATURES
    if each.when is not always and each.public != ("hosted_keys",)  # the host build has no display
]


@pytest.mark.parametrize("feature", OPTIONAL)
def test_every_feature_is_there_once_and_missing_once(feature):
    found = set()
    for name in host_specs.NAMES:
        spec = host_specs.spec_of(name)
        for loop in spec.controller.loops:
            found.add(bool(feature.when(loop_names(Source(spec, ("loops", loop)), loop, ""))))
    assert found == {True, False}
