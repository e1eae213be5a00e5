"""`check` tells what supply and switch of a heater in pulses have to bear."""

from pathlib import Path

import pytest
from rig.commands import Heatwright
from rig.firmware import EXAMPLES, changed, controller_of

from heatwright.cli.loads import loads, told

SUPPLY_V, WIRE_OHM, LIMIT_A = 43.0, 8.54, 3.0
"""The fabricator's, as published."""


def test_the_fabricators_wire_draws_five_amperes_and_three_rms() -> None:
    (load,) = loads(controller_of("fabricator"))
    assert load["peak_a"] == pytest.approx(SUPPLY_V / WIRE_OHM, rel=1e-3)
    assert load["rms_a"] == pytest.approx(LIMIT_A, rel=2e-3)
    assert load["full_w"] == pytest.approx(load["rms_a"] ** 2 * WIRE_OHM, rel=1e-3)
    assert load["mean_a"] == pytest.approx(load["full_w"] / SUPPLY_V)
    assert load["dead_w"] == pytest.approx(SUPPLY_V**2 / WIRE_OHM, rel=1e-3)
    assert told(load).startswith(
        "heater: supply and switch carry 5.04 A while it is on; at full duty"
    )


def test_without_a_lower_rating_all_three_are_one() -> None:
    (load,) = loads(controller_of(changed("fabricator", (", rated: 25.57 V", ""))))
    assert load["peak_a"] == load["rms_a"] == load["mean_a"] == pytest.approx(76.6 / SUPPLY_V)
    assert load["dead_w"] == load["full_w"]


@pytest.mark.parametrize("name", ["chamber", "extruder", "kiln"])
def test_nothing_is_told_of_what_has_no_such_currents(name: str) -> None:
    assert not list(loads(controller_of(name)))


def test_check_prints_it(heatwright: Heatwright) -> None:
    text = (EXAMPLES / "fabricator.yaml").read_text(encoding="utf-8")
    Path("fabricator.yaml").write_text(text, encoding="utf-8")
    (load,) = loads(controller_of("fabricator"))
    assert f"  {told(load)}\n" in heatwright("check --quick fabricator.yaml").out
    (listed,) = heatwright("check --quick fabricator.yaml chamber.yaml --json").json["loads"]
    assert listed == {"file": "fabricator.yaml", **load}
