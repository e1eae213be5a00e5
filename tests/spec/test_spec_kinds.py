"""Every kind of heatwright's own has all that a kind needs, and few ask of which kind a thing is.
What the rest of the program needs to know of a kind, the kind says (a property, or a constant of
its class): then mypy lists what a new one lacks. To ask for a kind is left to the kind's own files,
whose path has one of the words of its name. All that a kind needs is there by the rule for
packages."""

import ast
import json
import os
import re
import sys
import tomllib
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, get_type_hints

import pytest
from rig.bad_specs import bases
from rig.firmware import EXAMPLES, ROOT, changed, controller_of, finished, sources_of

from heatwright.cli.contract import UNIONS, lacking
from heatwright.generator.plan.core import rule_macro
from heatwright.spec import Algorithm, Interface, Output, Sensor, facts_of, kinds
from heatwright.spec.base import Model
from heatwright.spec.registry import KindIncomplete, brought, module_of
from heatwright.spec.rules import RULES
from heatwright.spec.sensing.analog_parts import AnalogSensor

ASKED = 35  # places that ask elsewhere: whoever takes one away lowers it
READ = 30  # files that read a loop's period; `Loop` says what follows from it, as `periods_s`
ROLES = {"sensor": Sensor, "output": Output, "algorithm": Algorithm, "interface": Interface}


def classes() -> dict[str, str]:
    """The kinds by the names of their models, simulations and algorithms' reference models."""
    found = {AnalogSensor.__name__: "analog"}
    for role, kind, model in (
        (role, *each) for role, union in ROLES.items() for each in kinds(union).items()
    ):
        stem = "reference" if role == "algorithm" else "simulated"
        module = import_module(module_of(role, stem, kind))
        made = module.Control if stem == "reference" else get_type_hints(module.attach)["return"]
        found[model.__name__] = kind
        if made.__module__.startswith(module.__name__):  # it is not shared by several kinds
            found[made.__name__] = kind
    return found


CLASSES = classes()


def asked_in(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield the line and the kind of each question. A question is a kind's class handed to a
    function, as to `isinstance` or `placed`, or matched; a comparison with the kind's name; and an
    algorithm's `pid`, which only one kind has."""
    for node in ast.walk(tree):
        match node:
            case ast.Call(args=[*given]):
                handed = [each for one in given for each in _alternatives(one)]
                yield from ((node.lineno, CLASSES[name]) for name in handed if name in CLASSES)
            case ast.MatchClass(cls=ast.Name(name)) if name in CLASSES:
                yield node.lineno, CLASSES[name]
            case ast.Attribute(value=of, attr="pid") if ast.unparse(of).endswith("algorithm"):
                yield node.lineno, "pid"
            case ast.Compare(left=left, comparators=[*others]):
                parts = [left, *others]
                if any(isinstance(each, ast.Attribute) and each.attr == "kind" for each in parts):
                    inner = (each for part in parts for each in ast.walk(part))
                    strings = {each.value for each in inner if isinstance(each, ast.Constant)}
                    yield from ((node.lineno, kind) for kind in CLASSES.values() if kind in strings)


def _alternatives(given: ast.expr) -> list[str]:
    """Return the names in an argument such as `Pid`, `Pid | OnOff` or `(Pid, OnOff)`."""
    if isinstance(given, ast.Name | ast.BinOp | ast.Tuple):
        return [each.id for each in ast.walk(given) if isinstance(each, ast.Name)]
    return []


@pytest.mark.parametrize(
    "question",
    [
        "isinstance(x, Pid)", "isinstance(x, Pid | OnOff)", "placed(controller, Pid)",
        "device.parts(PidControl)", "loop.algorithm.pid", "x.kind == 'pid'",
    ],
)  # fmt: skip
def test_a_question_is_seen(question: str) -> None:
    assert (1, "pid") in set(asked_in(ast.parse(question)))


def is_own(path: str, kind: str) -> bool:
    words = {word.removesuffix("s") for word in re.split(r"\W|_", path)}
    own = (word.removesuffix("s") for word in kind.split("_"))
    return not words.isdisjoint(own)


def test_kinds_are_asked_for_in_their_own_files() -> None:
    found = {
        (path.relative_to(ROOT).as_posix(), line)
        for folder in ("spec", "generator", "sim", "cli")
        for path in (ROOT / folder).rglob("*.py")
        for line, kind in asked_in(ast.parse(path.read_text("utf-8")))
        if not is_own(path.relative_to(ROOT).as_posix(), kind)
    }
    assert len(found) == ASKED, sorted(found)


def test_what_follows_from_a_period_is_said_once() -> None:
    found = [
        path.relative_to(ROOT).as_posix()
        for folder in ("spec", "generator", "templates", "sim", "cli")
        for path in (ROOT / folder).rglob("*")
        if path.suffix in {".py", ".j2"} and ".period_s" in path.read_text("utf-8")
    ]
    assert len(found) <= READ, sorted(found)


OUTSIDE = sorted(each.parent for each in (ROOT / "examples").glob("*/pyproject.toml"))


@pytest.mark.parametrize(
    ("role", "kind"), [(role, kind) for role, union in UNIONS.items() for kind in kinds(union)]
)
def test_nothing_is_missing(role: str, kind: str) -> None:
    assert list(lacking(role, kind)) == []


@pytest.mark.parametrize("role", UNIONS)
def test_no_kind_inherits_what_every_kind_must_say(role: str) -> None:
    """What all kinds of a role inherit, a new one has without a word: mypy would not list it."""
    models = [model for kind, model in kinds(UNIONS[role]).items() if kind not in brought(role)]
    common = set.intersection(*(set(model.__mro__) for model in models))
    assert common - {*models} == {*Model.__mro__}


@pytest.mark.parametrize("example", [path.stem for path in EXAMPLES.glob("*.yaml")])
def test_a_thermometer_says_which_rules_its_driver_can_report(example: str) -> None:
    """And the firmware names these, with the rules that every firmware names."""
    controller, texts = controller_of(example), sources_of(example)
    codes = {rule_macro(rule): code for code, rule in RULES.items()}
    for name, sensor in controller.thermometers.items():
        driver = texts[f"sensor_{name}.c"] + texts.get(f"one_wire_{name}.c", "")
        named = {codes[each] for each in re.findall(r"\bFAULT_\w+", driver) if each in codes}
        assert named == {*sensor.rules}
    own = {code for sensor in controller.sensors.values() for code in sensor.rules}
    listed = {rule.code for rule in facts_of(controller).rules} & {17, 18, 20, 21, 22}
    assert listed == own - {1, 2, 3, 4, 5}


def test_a_module_that_is_missing_is_named() -> None:
    with pytest.raises(KindIncomplete, match=r"write .*/reference/sensors/spoon\.py, which"):
        module_of("sensor", "reference", "spoon")
    told = "pyproject.toml: no entry point sensor.spoon in heatwright.kinds that is installed"
    assert list(lacking("sensor", "spoon")) == [told]


def beside(home: Path, named: dict[str, str], *words: str, package: Path) -> Any:
    """Run heatwright as if a package were installed beside it; tests/packaging installs one."""
    lines = ["[heatwright.kinds]", *(f"{name} = {place}" for name, place in named.items())]
    (home / "outside-1.dist-info").mkdir()
    (home / "outside-1.dist-info" / "entry_points.txt").write_text("\n".join(lines))
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (home, package)))}
    return finished([sys.executable, "-m", "heatwright.cli.start", *words], env=env)


@pytest.mark.parametrize("folder", OUTSIDE, ids=lambda each: each.name)
def test_a_package_among_the_examples_is_whole(folder: Path, tmp_path: Path) -> None:
    points = tomllib.loads((folder / "pyproject.toml").read_text("utf-8"))["project"]
    named = points["entry-points"]["heatwright.kinds"]
    told = beside(tmp_path, named, "kinds", "--json", package=folder)
    assert told.returncode == 0, told.stdout + told.stderr
    found = {f"{each['role']}.{each['kind']}": each for each in json.loads(told.stdout)["kinds"]}
    assert set(named) <= set(found)
    assert all(found[name]["package"] == f"heatwright_{folder.name}" for name in named)


CASCADE = '''
from typing import ClassVar, Literal
from heatwright.spec.algorithms import Pid

class Cascade(Pid):
    """Any duty, and none of the gains that heatwright reads."""
    pid: ClassVar[None] = None
    tunable: ClassVar[bool] = False
    kind: Literal["cascade"]
'''


@pytest.mark.parametrize(
    ("algorithm", "output", "fits"),
    [
        ("pid", "digital", False),
        ("cascade", "digital", False),
        ("cascade", "time_proportional", True),
    ],
)
def test_a_duty_of_any_size_needs_an_output_that_can_make_it(
    algorithm: str, output: str, fits: bool, tmp_path: Path
) -> None:
    (tmp_path / "lag").mkdir()
    (tmp_path / "lag" / "__init__.py").write_text("import heatwright.spec\n")
    (tmp_path / "lag" / "model.py").write_text(CASCADE)
    spec = changed(
        bases()["pid_oven"], ("kind: pid", f"kind: {algorithm}"),
        ("time_proportional", output), (", window: 1 s", ", window: 1 s" * fits),
    )  # fmt: skip
    (tmp_path / "oven.yaml").write_text(spec)
    words = ("check", "--quick", str(tmp_path / "oven.yaml"))
    told = beside(tmp_path, {"algorithm.cascade": "lag.model:Cascade"}, *words, package=tmp_path)
    assert told.returncode == (0 if fits else 2), told
    refusal = f"{algorithm} needs a duty between 0 % and 100 %, and heater of the kind digital is"
    assert (refusal in told.stdout + told.stderr) != fits, told
