"""One stem, every layer: each kind of the language is there in all of them."""

import re
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest
import yaml
from rig.bad_specs import cases

from heatwright.generator import plan_firmware
from heatwright.generator.plan.core import WATCHDOG_NAMES
from heatwright.spec import Algorithm, Interface, Output, Sensor, kinds, load
from heatwright.spec.controller import WATCHDOG_S

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "spec" / "examples").glob("*.yaml"))
FOLDERS = {"sensors": Sensor, "outputs": Output, "algorithms": Algorithm, "interfaces": Interface}
KINDS = [(folder, kind) for folder, union in FOLDERS.items() for kind in kinds(union)]

every_kind = pytest.mark.parametrize(("folder", "kind"), KINDS)


def test_the_folders_hold_nothing_that_is_no_kind() -> None:
    for folder, union in FOLDERS.items():
        shared = {"__init__", "common", "autotune"}
        plans = {path.stem for path in (ROOT / "generator" / "plan" / folder).glob("*.py")}
        assert plans - shared == set(kinds(union))


@every_kind
def test_it_is_planned_has_templates_and_is_simulated(folder: str, kind: str) -> None:
    """Templates go by its stem; an interface is made of several parts, which its plan names."""
    module = import_module(f"heatwright.generator.plan.{folder}.{kind}")
    assert callable(module.plan)
    templates = ROOT / "templates" / folder
    if folder == "interfaces":
        plan = (ROOT / "generator" / "plan" / folder / f"{kind}.py").read_text("utf-8")
        assert any(f'"interfaces/{path.name}"' in plan for path in templates.glob("*.c*"))
    else:
        for ending in (".c", ".h"):
            found = [path.name for path in templates.glob(f"{kind}{ending}*")]
            assert len(found) == 1, found
    simulated = "reference" if folder == "algorithms" else folder
    assert find_spec(f"heatwright.sim.{simulated}.{kind}") is not None


def used_kinds(path: Path) -> set[str]:
    """Every `kind` anywhere in a file."""
    found, left = set(), [yaml.safe_load(path.read_text("utf-8"))]
    while left:
        part = left.pop()
        if isinstance(part, dict):
            found.add(part.get("kind"))
            left += part.values()
        elif isinstance(part, list):
            left += part
    return {kind for kind in found if isinstance(kind, str)}


@every_kind
def test_an_example_uses_it(folder: str, kind: str) -> None:
    assert any(kind in used_kinds(example) for example in EXAMPLES)


@every_kind
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


def test_every_part_of_the_firmware_has_its_file() -> None:
    """A sensor, an output and a loop each bring the files that carry their name."""
    for example in EXAMPLES:
        spec = load(example)
        paths = {file.path for file in plan_firmware(spec).files}
        controller = spec.controller
        relay = controller.safety.relay  # it is the gate's own, and no heater's
        assert (relay is None) == ("src/relay.c" not in paths)
        for prefix, names in (
            ("sensor", controller.sensors), ("output", set(controller.outputs) - {relay}),
            ("loop", controller.loops), ("guard", controller.loops),
            ("algorithm", controller.loops),
        ):  # fmt: skip
            for name in names:
                assert {f"src/{prefix}_{name}.c", f"src/{prefix}_{name}.h"} <= paths


def test_every_watchdog_period_has_its_name_in_avr_libc() -> None:
    assert set(WATCHDOG_NAMES) == set(WATCHDOG_S)
    header = Path("/usr/lib/avr/include/avr/wdt.h").read_text("utf-8", errors="replace")
    for name in WATCHDOG_NAMES.values():
        assert re.search(rf"#define\s+WDTO_{name}\b", header)
