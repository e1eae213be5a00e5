"""The specifications of the host build take every branch of the templates, both ways."""

import re
from collections import defaultdict
from functools import cache
from importlib.resources import files

import host_specs
import pytest
from jinja2 import Environment

from heatwright.generator import plan_firmware
from heatwright.generator.plan.loop.features import FEATURES
from heatwright.generator.plan.loop.names import loop_names
from heatwright.generator.plan.loop.steps import always
from heatwright.generator.plan.source import Source
from heatwright.generator.render import names

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
    """Every file of every build, by its template; planned once."""
    found = defaultdict(list)
    for name in host_specs.NAMES:
        for file in plan_firmware(host_specs.spec_of(name)).files:
            context = names(file.told)
            context["control"] = (context.get("loops") or [{}])[0]
            for template in (file.template, *pieces_of(context)):
                found[template].append(context)
    return found


def pieces_of(context):
    """Templates that the features of a loop add to its own."""
    return (*context.get("helpers", ()), *context.get("public", ()))


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
