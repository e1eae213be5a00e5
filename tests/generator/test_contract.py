"""One stem, every layer: each kind of the language is there in all of them."""

import re
from pathlib import Path

import pytest
from rig.bad_specs import cases
from rig.specs import EXAMPLES

from heatwright.generator.plan.core import WATCHDOG_NAMES
from heatwright.spec import Algorithm, Interface, Output, Sensor, kinds
from heatwright.spec.controller import WATCHDOG_S

ROOT = Path(__file__).parents[2]
FOLDERS = {"sensors": Sensor, "outputs": Output, "algorithms": Algorithm, "interfaces": Interface}
KINDS = [(folder, kind) for folder, union in FOLDERS.items() for kind in kinds(union)]


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
