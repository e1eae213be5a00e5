"""identify and tune: from logs of our own making to YAML that a spec takes."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from rig.commands import Heatwright, changed
from rig.firmware import EXAMPLES
from test_fit import as_csv, machine, recorded, steps

from heatwright.cli.identify.block import digits
from heatwright.sim.identify import Found
from heatwright.sim.identify.structure import Parameter
from heatwright.spec import ThermalNetwork, load_text


def written(name: str, network: ThermalNetwork, duty: Any) -> Path:
    Path(name).write_text(as_csv(recorded(network, steps(*duty))), encoding="utf-8")
    return Path(name)


@pytest.fixture
def step_log(heatwright: Heatwright) -> Path:
    return written("step.csv", machine(delay=2.0, noise=0.05), (600, (20, 1.0), (400, 0.3)))


def test_what_is_printed_is_yaml_of_the_language(heatwright: Heatwright, step_log: Path) -> None:
    done = heatwright(f"identify {step_log} --power 40W")
    assert done.out.startswith("# heatwright identify"), "the block alone, for a pipe"
    assert done.err.startswith("Reading the log …\n")
    plant = yaml.safe_load(done.out)["simulation"]["plant"]
    assert float(plant["nodes"]["body"].split()[0]) == pytest.approx(16.7, rel=0.01)
    assert plant["heat"] == {"heater": "body"}
    assert "WARNING" not in done.out
    assert re.search(r"^# Fit error 0\.0\d+ K rms, 0\.\d+ K at most", done.out, re.MULTILINE)
    assert "0 → 40 W after 20 s" in done.out


def test_the_block_pastes_into_a_spec(heatwright: Heatwright) -> None:
    heatwright("simulate oven.yaml --model --csv run.csv")
    done = heatwright("identify run.csv --spec oven.yaml --cold")
    text = (EXAMPLES / "oven.yaml").read_text(encoding="utf-8")
    pasted = text[: text.index("# The oven itself")] + done.out + "  scenario: [{for: 60 min}]\n"
    plant = load_text(pasted).controller.simulation
    assert plant is not None
    assert (plant.plant.heat, plant.ambient_c) == ({"heater": "air"}, pytest.approx(24.9, abs=4))


def test_an_unnamed_column_is_that_of_the_loop(heatwright: Heatwright) -> None:
    Path("alone").write_text(
        "scenario: [{at: 2 s, write: {die.setpoint: 150 °C, die.enabled: true}}, {for: 20 min}]",
        encoding="utf-8",
    )
    barrel = EXAMPLES / "barrel.yaml"
    heatwright(f"simulate {barrel} --model --scenario alone --csv run.csv")
    found = yaml.safe_load(heatwright(f"identify run.csv --spec {barrel} --loop die --cold").out)
    plant = found["simulation"]["plant"]
    assert plant["heat"] == {"die_heater": "die"}
    assert float(plant["nodes"]["die"].split()[0]) == pytest.approx(900, rel=0.1)


def test_json_has_the_intervals_and_files_are_written(
    heatwright: Heatwright, step_log: Path
) -> None:
    words = "--power 40W -o plant.yaml --plot fit.svg --json"
    found = heatwright(f"identify {step_log} {words}").json
    assert (found["log"], found["readings"], found["warnings"]) == ("step.csv", 600, [])
    assert found["steps"][0] == {"time_s": 20.0, "before_W": 0.0, "after_W": 40.0}
    capacity = found["parameters"]["capacity_body"]
    assert capacity["low"] < capacity["value"] < capacity["high"]
    assert (capacity["unit"], capacity["told"]) == ("J/K", True)
    assert found["fit"]["rms"] == pytest.approx(0.05, rel=0.1)
    assert yaml.safe_load(found["yaml"])["simulation"]["plant"]["kind"] == "thermal_network"
    assert Path("plant.yaml").read_text(encoding="utf-8") == found["yaml"]
    assert "<svg" in Path("fit.svg").read_text(encoding="utf-8")


def test_the_firmwares_plotter_lines_need_only_the_spec(heatwright: Heatwright) -> None:
    duty = steps(1500, (20, 1.0), (900, 0.2))
    record = recorded(machine(400.0, 0.4, 20.0, 1.0), duty, step_k=0.06)
    lines = [
        f"${read_c:.2f} 50.00 {power_w / 4:.2f} 0.00;"
        for read_c, power_w in zip(record.readings_c, record.powers_w, strict=True)
    ]
    Path("plotter.log").write_text("garbage\n" + "\n".join(lines), encoding="utf-8")
    found = heatwright("identify plotter.log --spec chamber.yaml --json").json
    # The record's 40 W at full duty are the spec's 240 W here.
    assert found["parameters"]["capacity_air"]["value"] == pytest.approx(400 * 240 / 40, rel=0.02)
    # A reading is 0.78 s old when it is logged, which is no dead time of the machine.
    delay = found["parameters"]["delay"]
    assert delay["low"] <= 1.0 - 0.78 <= delay["high"]
    assert list(yaml.safe_load(found["yaml"])["simulation"]["plant"]["sense"]) == ["air"]


def test_the_block_warns_where_a_record_tells_too_little(heatwright: Heatwright) -> None:
    written("short.csv", machine(noise=0.3), (40, (20, 1.0)))
    told = heatwright("identify short.csv --power 40W").out
    assert "# WARNING: this record does not show the resistance body – ambient" in told
    assert "# NOT DETERMINED by this record" in told


@pytest.mark.parametrize(
    ("value", "half", "text"),
    [
        (16.7123, 0.02, "16.712"), (-5.43, 0.4, "-5.43"), (1e-15, 36.0, "0.00"),
        (-1e-15, 0.1, "0.0000"), (123456.0, 5000.0, "123500"), (0.173, float("inf"), "0.173"),
    ],
)  # fmt: skip
def test_numbers_have_the_digits_that_are_told(value: float, half: float, text: str) -> None:
    parameter = Parameter("lag", "lag of the sensor", "s", False)
    assert digits(Found(parameter, value, value - half, value + half, told=True)) == text


def only(found: Any) -> Any:
    (each,) = found["loops"].values()
    return each


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
    whole = heatwright("tune oven.yaml --method simc --plot tune.svg --json").json
    assert (list(whole["loops"]), whole["skipped"]) == (["air"], {})
    found = only(whole)
    assert (found["at"], found["chosen"]) == (50.0, "simc")
    assert [each["method"] for each in found["methods"]] == ["as it is", "simc"]
    simc = row(found, "simc")
    assert simc["margins"]["stable"]
    assert simc["margins"]["gain"] > 2
    assert simc["closed_loop"]["overshoot"] < 1
    assert simc["load"]["dip"] > 0
    kp = yaml.safe_load(found["yaml"])["algorithm"]["kp"]
    assert kp == pytest.approx(simc["gains"]["kp"], rel=1e-3)
    assert "<!-- time [s] -->" in Path("tune.svg").read_text(encoding="utf-8"), "not minutes"


def test_all_loops_in_turn_or_those_that_are_named(heatwright: Heatwright) -> None:
    switch = "{kind: time_proportional, pin: D10, window: 2 s, power: 300 W}"
    spec = changed("barrel", switch, "{kind: digital, pin: D10, power: 300 W}")
    text = Path(spec).read_text("utf-8")
    pid = text[text.rindex("algorithm:") : text.rindex("    protection:")]
    Path(spec).write_text(text.replace(pid, "algorithm: {kind: on_off}\n"), "utf-8")
    found = heatwright(f"tune {spec} --method simc --json").json
    assert [(loop, each["at"]) for loop, each in found["loops"].items()] == [("barrel", 210.0)]
    assert row(found["loops"]["barrel"], "simc")["closed_loop"]["overshoot"] < 5
    assert "heater die_heater is only switched on and off" in found["skipped"]["die"]
    words = f"tune {EXAMPLES / 'barrel.yaml'} --loop die --method lambda --plot x.svg"
    assert "# loops.die\nalgorithm:" in heatwright(words).out


def test_slower_is_more_robust(heatwright: Heatwright) -> None:
    for method, option in (("lambda", "--lambda 60s"), ("simc", "--tauc 30s")):
        quick, slow = (
            row(only(heatwright(f"tune oven.yaml --method {method} {words} --json").json), method)
            for words in ("", option)
        )
        assert quick["gains"]["kp"] > slow["gains"]["kp"]


@pytest.mark.parametrize(("name", "at"), [("extruder", 200.0), ("dryer", 70.0)])
def test_the_firmwares_own_experiment(heatwright: Heatwright, name: str, at: float) -> None:
    """What the project promises of its autotune, where the scenario or a master in it heats to."""
    found = only(heatwright(f"tune {EXAMPLES / name}.yaml --method relay --json").json)
    relay = row(found, "relay")
    assert (found["at"], relay["failed"], relay["faults"]) == (at, None, [])
    assert relay["margins"]["gain"] >= 2
    assert relay["margins"]["phase_deg"] >= 45
    assert relay["closed_loop"]["overshoot"] <= 1
    least, most = relay["gains"]["integral_percent"]
    assert 0 <= least < most <= 100


def test_an_experiment_that_fails_is_told(heatwright: Heatwright) -> None:
    spec = changed("extruder", "autotune: {", "autotune: {timeout: 140 s, ")
    told = heatwright(f"tune {spec} --method relay", status=1).out
    assert "relay: no gains: it took longer than its time-out" in told
    assert "algorithm:" not in told
    found = only(heatwright(f"tune {spec} --method relay --json", status=1).json)
    assert (found["chosen"], found["yaml"]) == (None, None)


def test_an_on_off_loop_gets_a_pid(heatwright: Heatwright) -> None:
    window = "{kind: time_proportional, pin: D3, window: 1 s, power: 240 W}"
    spec = changed("chamber", "{kind: digital, pin: D3, power: 240 W}", window)
    (simc,) = only(heatwright(f"tune {spec} --method simc --at 50C --json").json)["methods"]
    assert simc["method"] == "simc"
    assert simc["gains"]["derivative_filter_s"] > 0
    assert simc["closed_loop"]["maximum"] < 55
