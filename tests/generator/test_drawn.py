"""Each kind of the language is in all layers, and controllers drawn from it are accepted, compiled,
and run in step with the reference."""

import re
from collections import Counter
from itertools import islice, product
from pathlib import Path
from random import Random
from typing import Any

import pytest
from jinja2 import Environment, FunctionLoader, StrictUndefined, nodes
from rig.bad_specs import cases
from rig.controllers import Drawn, attempts, drawings
from rig.firmware import EXAMPLES, ROOT, files_of, whole
from suite import SEED, amount

from heatwright.generator import plan_firmware
from heatwright.generator.plan.core import WATCHDOG_NAMES
from heatwright.generator.render import _load, names
from heatwright.generator.stack import worst_stack
from heatwright.generator.toolchain.build import ANY_SIZE
from heatwright.generator.toolchain.result import sizes
from heatwright.sim.bench import bench
from heatwright.sim.binary.elf import Elf
from heatwright.sim.device import AvrDevice
from heatwright.sim.replay import replay_all
from heatwright.spec import BOARDS, Algorithm, Interface, Output, Sensor, SpecError, kinds
from heatwright.spec.board.least import Least, fits, least
from heatwright.spec.controller import WATCHDOG_S, Controller

TEMPLATES = ROOT / "templates"
LARGE_FLASH = 100_000
"""Bytes; no drawn firmware takes that much."""
CODE = (".c", ".h")
FOLDERS = {"sensors": Sensor, "outputs": Output, "algorithms": Algorithm, "interfaces": Interface}
KINDS = [(folder, kind) for folder, union in FOLDERS.items() for kind in kinds(union)]


def test_most_of_what_is_drawn_is_accepted() -> None:
    """And no reason keeps much out: what is refused again and again would never be tried."""
    count = amount("drawn_attempts")
    found = attempts(count)
    assert sum(isinstance(each, Drawn) for each in found) >= 0.8 * count
    reasons: Counter[str] = Counter()
    for each in found:
        if isinstance(each, SpecError):
            reasons.update({re.sub(r"[-\d.]+", "#", problem.reason) for problem in each.problems})
    assert [each for each in reasons.most_common() if each[1] > 0.05 * count + 1] == []


class Noting(Environment):
    """Tells of each condition, wherever one stands in a template, whether it was true."""

    def __init__(self) -> None:
        super().__init__(
            loader=FunctionLoader(self._noted_text), undefined=StrictUndefined, trim_blocks=True
        )  # as the generator's own
        self.loaded: set[str] = set()
        """All templates in use: what these include or extend, too."""
        self.places: set[str] = set()
        """Template and line, for each condition."""
        self.seen: set[tuple[str, bool]] = set()
        self.globals["noted"] = self._noted

    @property
    def unseen(self) -> set[tuple[str, bool]]:
        """Values that no condition has had yet."""
        return set(product(self.places, (True, False))) - self.seen

    def _noted_text(self, template: str) -> str:
        self.loaded.add(template)
        return _load(template)

    def _noted(self, place: str, value: Any) -> Any:
        self.seen.add((place, bool(value)))
        return value

    def _parse(self, source: str, name: str | None, filename: str | None) -> nodes.Template:
        tree = super()._parse(source, name, filename)
        asked = [each for each in tree.find_all((nodes.If, nodes.CondExpr, nodes.For)) if each.test]
        for number, each in enumerate(asked):
            line = source.splitlines()[each.lineno - 1]
            place = f"{name}:{each.lineno}:{number} {line.strip()}"
            self.places.add(place)
            known = nodes.Name("noted", "load")
            each.test = nodes.Call(known, [nodes.Const(place), each.test], [], None, None)
        return tree


def test_every_kind_template_and_condition_is_drawn() -> None:
    """Of each condition of each template, wherever one stands in it, both values."""
    noting, found = Noting(), set[str]()
    files = [path for path in TEMPLATES.glob("*/**/*") if path.suffix in {*CODE, ".j2", ".py"}]
    templates = {path.relative_to(TEMPLATES).as_posix() for path in files}
    every = {*BOARDS, *(kind for _, kind in KINDS)}
    random = Random(f"conditions {SEED}")  # noqa: S311 - no secret
    for each in islice(drawings(random, seldom=3), amount("drawn_planned")):
        for file in plan_firmware(each.spec).files:
            noting.get_template(file.template).render(names(file.told))
        found |= kinds_in(each.spec.controller)
        if noting.loaded == templates and not noting.unseen and found == every:
            break  # more of them would show no more
    assert noting.loaded == templates
    assert noting.unseen == set()
    assert found == every


def kinds_in(controller: Controller) -> set[str]:
    loops = controller.loops.values()
    parts = [*controller.sensors.values(), *controller.outputs.values(), *controller.interfaces]
    kinds_of_parts = {each.kind for each in (*parts, *(loop.algorithm for loop in loops))}
    return kinds_of_parts | {controller.board.name}


@pytest.mark.parametrize("number", range(amount("drawn_compiled")))
def test_any_compiles_and_runs(number: int) -> None:
    random = Random(f"compiled {SEED} {number}")  # noqa: S311 - no secret
    assert_it_compiles_and_runs(next(drawings(random)))


def assert_it_compiles_and_runs(drawn: Drawn) -> None:
    files = files_of(drawn.text)
    code = Counter(re.findall(r"\w+", "".join(files[path] for path in files if path[-2:] in CODE)))
    constants = re.findall(r"^#define (\w+) .+$", files["src/config.h"], re.MULTILINE)
    assert [name for name in constants if code[name] < 2] == []
    controller = drawn.spec.controller
    elf = whole(drawn.text, *project_flags(files["platformio.ini"]), ANY_SIZE)
    taken = Least(sizes(elf.path)[0], sizes(elf.path)[1] + worst_stack(elf.path).total)
    assert taken.flash < LARGE_FLASH, drawn
    bounds = zip(least(controller), taken, strict=True)
    assert all(bound <= each for bound, each in bounds), drawn  # no less is warned of or refused
    if controller.simulation is not None and fits(taken, controller.board):
        assert_it_equals_the_reference(controller, elf, drawn)


def assert_it_equals_the_reference(controller: Controller, elf: Elf, drawn: Drawn) -> None:
    logs = bench(controller, AvrDevice(controller, elf)).steps
    logs = {name: log for name, log in logs.items() if len(log)}  # a period may be long
    for loop, result in replay_all(controller, logs).items():
        assert (result.mismatches, result.segments) == (0, 1), (loop, result.first, drawn)
        assert result.restored == (), (loop, drawn)


def project_flags(ini: str) -> list[str]:
    found = re.search(r"^build_flags =\n((?: +.*\n)+)", ini, re.MULTILINE)
    assert found is not None
    flags = found[1].split()
    assert {"-Werror", "-Wpedantic", "-Wconversion", "-std=c11"} <= set(flags)
    return flags


def test_the_folders_hold_nothing_that_is_no_kind() -> None:
    for folder, union in FOLDERS.items():
        shared = {"__init__", "common", "autotune"}
        plans = {path.stem for path in (ROOT / "generator" / "plan" / folder).glob("*.py")}
        assert plans - shared == set(kinds(union))


def test_an_example_uses_every_kind() -> None:
    texts = [path.read_text("utf-8") for path in EXAMPLES.glob("*.yaml")]
    used = {kind for text in texts for kind in re.findall(r"\bkind: (\w+)", text)}
    assert {kind for _, kind in KINDS} <= used


@pytest.mark.parametrize(("folder", "kind"), KINDS)
def test_a_bad_spec_is_about_it(folder: str, kind: str) -> None:
    """One of its keys, or it by name, is objected to; that it occurs would show nothing."""
    own = {field.alias or name for name, field in kinds(FOLDERS[folder])[kind].model_fields.items()}
    section = "loops" if folder == "algorithms" else folder
    for case in cases().values():
        text = case.text.decode(errors="replace")
        messages = [line for line in case.messages if f" {section}" in line]
        if f"kind: {kind}" in text and any(
            f".{key}:" in line or kind in line for line in messages for key in own
        ):
            return
    pytest.fail(f"nothing in tests/bad_specs objects to a key of {kind}")


def test_every_watchdog_period_has_its_name_in_avr_libc() -> None:
    assert set(WATCHDOG_NAMES) == set(WATCHDOG_S)
    header = Path("/usr/lib/avr/include/avr/wdt.h").read_text("utf-8", errors="replace")
    for name in WATCHDOG_NAMES.values():
        assert re.search(rf"#define\s+WDTO_{name}\b", header)
