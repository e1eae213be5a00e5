"""tune: methods side by side, margins, a block to paste."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from conftest import EXAMPLES, Heatwright

QUICK = ("--method", "simc")


def row(found: Any, method: str) -> Any:
    (each,) = (each for each in found["methods"] if each["method"] == method)
    return each


def test_methods_stand_side_by_side(heatwright: Heatwright) -> None:
    done = heatwright("tune", "oven.yaml")
    assert done.status == 0
    for word in ("as it is", "simc", "lambda", "gain margin", "Ms", "From cold to 50 °C"):
        assert word in done.out
    assert "relay" not in done.out
    block = yaml.safe_load(done.out[done.out.index("algorithm:") :])["algorithm"]
    assert block["kind"] == "pid"
    assert block["kp"] > 0
    assert block["derivative_filter"] == "3 s"


def test_json_and_a_picture(heatwright: Heatwright) -> None:
    found = heatwright("tune", "oven.yaml", *QUICK, "--plot", "tune.png", "--json").json
    assert (found["loop"], found["at"], found["chosen"]) == ("air", 50.0, "simc")
    assert [each["method"] for each in found["methods"]] == ["as it is", "simc"]
    simc = row(found, "simc")
    assert simc["margins"]["stable"]
    assert simc["margins"]["gain"] > 2
    assert simc["closed_loop"]["overshoot"] < 1
    assert simc["load"]["dip"] > 0
    assert yaml.safe_load(found["yaml"])["algorithm"]["kp"] == pytest.approx(
        simc["gains"]["kp"], rel=1e-3
    )
    assert Path("tune.png").read_bytes().startswith(b"\x89PNG")


def test_slower_is_more_robust(heatwright: Heatwright) -> None:
    words = ("tune", "oven.yaml", "--method", "lambda", "--json")
    quick = row(heatwright(*words, "--lambda", "10s").json, "lambda")
    slow = row(heatwright(*words, "--lambda", "60s").json, "lambda")
    assert quick["gains"]["kp"] > slow["gains"]["kp"]
    assert quick["margins"]["sensitivity"] > slow["margins"]["sensitivity"]
    assert quick["load"]["dip"] < slow["load"]["dip"]
    words = ("tune", "oven.yaml", *QUICK, "--json")
    tight = row(heatwright(*words).json, "simc")
    loose = row(heatwright(*words, "--tauc", "30s").json, "simc")
    assert tight["margins"]["phase_deg"] < loose["margins"]["phase_deg"]


def test_the_firmwares_own_experiment(heatwright: Heatwright) -> None:
    spec = EXAMPLES / "extruder.yaml"
    found = heatwright("tune", spec, "--method", "relay", "--json").json
    relay = row(found, "relay")
    assert found["at"] == 200.0, "what the scenario asks for"
    assert relay["failed"] is None
    # What the project promises of its autotune.
    assert relay["margins"]["gain"] >= 2
    assert relay["margins"]["phase_deg"] >= 45
    assert relay["closed_loop"]["overshoot"] <= 1
    assert relay["faults"] == []


def test_the_experiment_of_a_loop_under_a_master(heatwright: Heatwright) -> None:
    found = heatwright("tune", EXAMPLES / "dryer.yaml", "--method", "relay", "--json").json
    relay = row(found, "relay")
    assert found["at"] == 70.0, "what the master writes in the scenario"
    assert relay["failed"] is None
    assert relay["margins"]["gain"] >= 2
    assert relay["closed_loop"]["overshoot"] <= 1
    assert relay["faults"] == []


def test_an_experiment_that_fails_is_told(heatwright: Heatwright) -> None:
    text = (EXAMPLES / "extruder.yaml").read_text(encoding="utf-8")
    assert "autotune: {" in text
    Path("short.yaml").write_text(
        text.replace("autotune: {", "autotune: {timeout: 140 s, "), encoding="utf-8"
    )
    done = heatwright("tune", "short.yaml", "--method", "relay")
    assert done.status == 1
    assert "relay: no gains: it took longer than its time-out" in done.out
    assert "algorithm:" not in done.out
    found = heatwright("tune", "short.yaml", "--method", "relay", "--json")
    assert (found.status, found.json["chosen"], found.json["yaml"]) == (1, None, None)


def test_an_on_off_loop_gets_a_pid(heatwright: Heatwright) -> None:
    text = Path("chamber.yaml").read_text(encoding="utf-8")
    changed = text.replace(
        "{kind: digital, pin: D3, power: 240 W}",
        "{kind: time_proportional, pin: D3, window: 1 s, power: 240 W}",
    )
    Path("tuned.yaml").write_text(changed, encoding="utf-8")
    found = heatwright("tune", "tuned.yaml", *QUICK, "--at", "50C", "--json").json
    assert [each["method"] for each in found["methods"]] == ["simc"]
    simc = row(found, "simc")
    assert simc["gains"]["derivative_filter_s"] > 0
    assert simc["closed_loop"]["maximum"] < 55


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("chamber.yaml",), "chamber.yaml: heater heater is switched on and off only"),
        (("oven.yaml", "--method", "relay"), "Loop air does not tune itself"),
        (("oven.yaml", "--method", "ziegler"), "'ziegler' is not one of"),
        (("oven.yaml", "--loop", "water"), "oven.yaml: has no loop water; there are air."),
        (("oven.yaml", "--at", "90C"), "--at 90 °C: the loop's setpoints are 10 °C to 70 °C"),
        (("oven.yaml", "--at", "15C"), "15 °C is no warmer than the ambient"),
        (("oven.yaml", "--at", "60"), "60 has no unit"),
        (("oven.yaml", "--lambda", "0s"), "--lambda: must be above 0"),
        (("oven.yaml", "--plot", "tune.html"), "name it with .png or .svg"),
        (("bare.yaml",), "bare.yaml: has no `simulation`"),
        (("missing.yaml",), "missing.yaml: no such file"),
    ],
)
def test_what_cannot_be_done_is_said(
    heatwright: Heatwright, words: tuple[str, ...], reason: str
) -> None:
    text = Path("oven.yaml").read_text(encoding="utf-8")
    Path("bare.yaml").write_text(text[: text.index("# The oven itself")], encoding="utf-8")
    done = heatwright("tune", *words)
    assert (done.status, done.out) == (2, "")
    assert reason in done.err


def test_help_has_examples(heatwright: Heatwright) -> None:
    done = heatwright("tune", "--help")
    assert done.status == 0
    assert "heatwright tune oven.yaml --method simc --at 60C --plot oven.png" in done.out
