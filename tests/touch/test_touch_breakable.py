"""Which rules have a page: those that can trip, and no others."""

from pathlib import Path
from typing import Any

import pytest

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.plan.core import rules
from heatwright.generator.toolchain import build
from heatwright.sim.elf import Elf
from heatwright.sim.faults.catalogue import catalogue
from heatwright.spec import Controller, load
from heatwright.spec.breakable import breakable
from heatwright.spec.nextion import display_pages

EXAMPLES = sorted((Path(__file__).parents[2] / "spec" / "examples").glob("*.yaml"))


def codes(controller: Controller) -> set[int]:
    return {rule.code for rule in breakable(controller)}


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_firmware_knows_them_all(path: Path) -> None:
    controller = load(path).controller
    assert codes(controller) <= {rule["code"] for rule in rules(controller)}


@pytest.mark.parametrize("name", ["kiln", "kiln_uno", "fabricator", "feeder"])
def test_whatever_the_catalogue_trips_is_among_them(name: str, tmp_path: Path) -> None:
    spec = load(EXAMPLES[0].with_name(f"{name}.yaml"))
    write(render(plan_firmware(spec)), tmp_path)
    faults = catalogue(spec.controller, Elf(build(tmp_path).elf))
    tripped = {rule for each in faults if each.trip for rule in each.trip.rules}
    assert tripped <= {rule.id for rule in breakable(spec.controller)}


def protected(controller: Controller, **changes: Any) -> Controller:
    loop = controller.loops["chamber"]
    protection = loop.protection.model_copy(update=changes)
    changed = loop.model_copy(update={"protection": protection})
    return controller.model_copy(update={"loops": {"chamber": changed}})


def test_what_is_switched_off_is_not(touched: Controller) -> None:
    assert codes(touched) == {1, 2, 3, 4, 5, 6, 7, 8, 14, 15, 16, 17, 18}


@pytest.mark.parametrize(
    ("key", "code"), [("frozen", 9), ("heating", 10), ("rising_while_off", 13)]
)
def test_each_that_is_on_is(touched: Controller, key: str, code: int) -> None:
    default = load(EXAMPLES[0]).controller
    rule = next(
        getattr(loop.protection, key)
        for loop in default.loops.values()
        if getattr(loop.protection, key) is not None
    )
    assert codes(protected(touched, **{key: rule})) - codes(touched) == {code}


def test_each_has_its_page(touched: Controller) -> None:
    pages = {page.name for page in display_pages(touched)}
    assert {name for name in pages if name.startswith("fault")} == {
        "faults", *(f"fault{code:02d}" for code in codes(touched)),
    }  # fmt: skip
