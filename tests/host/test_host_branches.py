"""The specifications of the host build take every branch of the templates, both ways."""

import re
from collections import defaultdict
from functools import cache
from importlib.resources import files

import host_specs
import pytest
from jinja2 import Environment

from heatwright.generator import plan_firmware

TEMPLATES = (
    "src/loop.c.j2", "src/loop_hosted.c.j2", "src/loop_regulates.c.j2", "src/loop_switched.c.j2",
    "src/current.c.j2", "src/guard.c.j2", "src/program.c.j2", "src/settings.c.j2", "src/gate.c.j2",
    "src/fault.c.j2", "algorithms/on_off.c.j2", "algorithms/lead.c.j2", "algorithms/pid.c.j2",
    "algorithms/three_position.c.j2", "algorithms/autotune.c.j2",
    "outputs/time_proportional.c.j2", "src/proof.c.j2", "src/proof.h.j2", "src/inputs.c.j2",
    "src/inputs.h.j2",
)  # fmt: skip
INCLUDED_BY = {
    "algorithms/lead.c.j2": "algorithms/three_position.c.j2",
    **dict.fromkeys(TEMPLATES[1:4], "src/loop.c.j2"),
}
CONDITION = re.compile(r"^\s*//% if (.*)$", re.MULTILINE)


@cache
def planned():
    """Every file of every build, by its template; planned once."""
    found = defaultdict(list)
    for name in host_specs.NAMES:
        for file in plan_firmware(host_specs.spec_of(name)).files:
            loops = file.context.get("loops") or [{}]
            found[file.template].append({**file.context, "control": loops[0]})
    return found


@pytest.mark.parametrize("template", TEMPLATES)
def test_every_condition_is_true_once_and_false_once(template):
    text = files("heatwright.templates").joinpath(template).read_text(encoding="utf-8")
    for condition in set(CONDITION.findall(text)):
        evaluate = Environment(autoescape=True).compile_expression(condition)
        contexts = planned()[INCLUDED_BY.get(template, template)]
        found = {bool(evaluate(**context)) for context in contexts}
        assert found == {True, False}, condition
