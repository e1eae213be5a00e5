"""tune: methods side by side, margins, a block to paste."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from rig.commands import Heatwright, changed
from rig.specs import EXAMPLES


def row(found: Any, method: str) -> Any:
    (each,) = (each for each in found["methods"] if each["method"] == method)
    return each


def test_methods_stand_side_by_side(heatwright: Heatwright) -> None:
    told = heatwright("tune oven.yaml").out
    for word in ("as it is", "simc", "lambda", "gain margin", "Ms", "From cold to 50 °C"):
        assert word in told
    assert "relay" not in told
    block = yaml.safe_load(told[told.index("algorithm:") :])["algorithm"]
    assert (block["kind"], block["derivative_filter"]) == ("pid", "3 s")
    assert block["kp"] > 0


def test_json_and_a_picture(heatwright: Heatwright) -> None:
    found = heatwright("tune oven.yaml --method simc --plot tune.png --json").json
    assert (found["loop"], found["at"], found["chosen"]) == ("air", 50.0, "simc")
    assert [each["method"] for each in found["methods"]] == ["as it is", "simc"]
    simc = row(found, "simc")
    assert simc["margins"]["stable"]
    assert simc["margins"]["gain"] > 2
    assert simc["closed_loop"]["overshoot"] < 1
    assert simc["load"]["dip"] > 0
    kp = yaml.safe_load(found["yaml"])["algorithm"]["kp"]
    assert kp == pytest.approx(simc["gains"]["kp"], rel=1e-3)
    assert Path("tune.png").read_bytes().startswith(b"\x89PNG")


def test_slower_is_more_robust(heatwright: Heatwright) -> None:
    for method, option in (("lambda", "--lambda 60s"), ("simc", "--tauc 30s")):
        quick, slow = (
            row(heatwright(f"tune oven.yaml --method {method} {words} --json").json, method)
            for words in ("", option)
        )
        assert quick["gains"]["kp"] > slow["gains"]["kp"]
        assert quick["margins"]["sensitivity"] > slow["margins"]["sensitivity"]
        assert quick["margins"]["phase_deg"] < slow["margins"]["phase_deg"]
        assert quick["load"]["dip"] < slow["load"]["dip"]


@pytest.mark.parametrize(("name", "at"), [("extruder", 200.0), ("dryer", 70.0)])
def test_the_firmwares_own_experiment(heatwright: Heatwright, name: str, at: float) -> None:
    """What the project promises of its autotune, where the scenario or a master in it heats to."""
    found = heatwright(f"tune {EXAMPLES / name}.yaml --method relay --json").json
    relay = row(found, "relay")
    assert (found["at"], relay["failed"], relay["faults"]) == (at, None, [])
    assert relay["margins"]["gain"] >= 2
    assert relay["margins"]["phase_deg"] >= 45
    assert relay["closed_loop"]["overshoot"] <= 1


def test_an_experiment_that_fails_is_told(heatwright: Heatwright) -> None:
    spec = changed("extruder", "autotune: {", "autotune: {timeout: 140 s, ")
    told = heatwright(f"tune {spec} --method relay", status=1).out
    assert "relay: no gains: it took longer than its time-out" in told
    assert "algorithm:" not in told
    found = heatwright(f"tune {spec} --method relay --json", status=1).json
    assert (found["chosen"], found["yaml"]) == (None, None)


def test_an_on_off_loop_gets_a_pid(heatwright: Heatwright) -> None:
    window = "{kind: time_proportional, pin: D3, window: 1 s, power: 240 W}"
    spec = changed("chamber", "{kind: digital, pin: D3, power: 240 W}", window)
    found = heatwright(f"tune {spec} --method simc --at 50C --json").json
    (simc,) = found["methods"]
    assert simc["method"] == "simc"
    assert simc["gains"]["derivative_filter_s"] > 0
    assert simc["closed_loop"]["maximum"] < 55
