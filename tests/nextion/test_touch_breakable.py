"""Which rules have a page: those that can trip, and no others."""

from typing import Any

import pytest
from hosted_kiln import PAGE, TOUCHED
from rig.avr import whole
from rig.specs import EXAMPLES, example

from heatwright.generator.plan.core import rules
from heatwright.sim.faults.catalogue import catalogue
from heatwright.spec import Controller
from heatwright.spec.breakable import breakable

NAMES = sorted(path.stem for path in EXAMPLES.glob("*.yaml"))


def codes(controller: Controller) -> set[int]:
    return {rule.code for rule in breakable(controller)}


@pytest.mark.parametrize("name", NAMES)
def test_the_firmware_knows_them_all(name: str) -> None:
    controller = example(name).controller
    assert codes(controller) <= {rule["code"] for rule in rules(controller)}


@pytest.mark.parametrize("name", ["kiln", "kiln_uno", "fabricator", "feeder"])
def test_whatever_the_catalogue_trips_is_among_them(name: str) -> None:
    controller = example(name).controller
    faults = catalogue(controller, whole(name))
    tripped = {rule for each in faults if each.trip for rule in each.trip.rules}
    assert tripped <= {rule.id for rule in breakable(controller)}


def protected(controller: Controller, **changes: Any) -> Controller:
    loop = controller.loops["chamber"]
    protection = loop.protection.model_copy(update=changes)
    changed = loop.model_copy(update={"protection": protection})
    return controller.model_copy(update={"loops": {"chamber": changed}})


def test_what_is_switched_off_is_not() -> None:
    assert codes(TOUCHED) == {1, 2, 3, 4, 5, 6, 7, 8, 14, 15, 16, 17, 18}


@pytest.mark.parametrize(
    ("key", "code"), [("frozen", 9), ("heating", 10), ("rising_while_off", 13)]
)
def test_each_that_is_on_is(key: str, code: int) -> None:
    rules_of = [loop.protection for loop in example(NAMES[0]).controller.loops.values()]
    rule = next(found for each in rules_of if (found := getattr(each, key)) is not None)
    assert codes(protected(TOUCHED, **{key: rule})) - codes(TOUCHED) == {code}


def test_each_has_its_page() -> None:
    assert {name for name in PAGE if name.startswith("fault")} == {
        "faults", *(f"fault{code:02d}" for code in codes(TOUCHED)),
    }  # fmt: skip
