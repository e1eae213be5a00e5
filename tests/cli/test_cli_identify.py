"""identify: from logs of our own making to YAML that a spec takes."""

import re
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from rig.commands import Heatwright
from rig.specs import EXAMPLES

from heatwright.cli.identify.block import digits
from heatwright.sim.identify import Found
from heatwright.sim.identify.structure import Parameter
from heatwright.spec import ThermalNetwork, load_text

sys.path.insert(0, str(Path(__file__).parents[1] / "identify"))

from known_machines import as_csv, machine, recorded, steps


def written(name: str, network: ThermalNetwork, duty: Any) -> Path:
    """Write what a machine does under steps of the duty."""
    Path(name).write_text(as_csv(recorded(network, steps(*duty))), encoding="utf-8")
    return Path(name)


@pytest.fixture
def step_log(heatwright: Heatwright) -> Path:
    """A noisy step, in the folder that the commands run in."""
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
    assert plant.plant.heat == {"heater": "air"}
    assert plant.ambient_c == pytest.approx(24.9, abs=4)


def test_json_has_the_intervals_and_files_are_written(
    heatwright: Heatwright, step_log: Path
) -> None:
    words = "--power 40W -o plant.yaml --plot fit.svg --json"
    found = heatwright(f"identify {step_log} {words}").json
    assert found["log"] == "step.csv"
    assert (found["readings"], found["warnings"]) == (600, [])
    assert found["steps"][0] == {"time_s": 20.0, "before_W": 0.0, "after_W": 40.0}
    capacity = found["parameters"]["capacity_body"]
    assert capacity["low"] < capacity["value"] < capacity["high"]
    assert (capacity["unit"], capacity["told"]) == ("J/K", True)
    assert found["fit"]["rms"] == pytest.approx(0.05, rel=0.1)
    assert yaml.safe_load(found["yaml"])["simulation"]["plant"]["kind"] == "thermal_network"
    assert Path("plant.yaml").read_text(encoding="utf-8") == found["yaml"]
    assert "<svg" in Path("fit.svg").read_text(encoding="utf-8")


def test_the_firmwares_plotter_lines_need_only_the_spec(heatwright: Heatwright) -> None:
    record = recorded(
        machine(400.0, 0.4, 20.0, 1.0), steps(1500, (20, 1.0), (900, 0.2)), step_k=0.06
    )
    lines = [
        f"${read_c:.2f} 50.00 {power_w / 4:.2f} 0.00;"
        for read_c, power_w in zip(record.readings_c, record.powers_w, strict=True)
    ]
    Path("plotter.log").write_text("garbage\n" + "\n".join(lines), encoding="utf-8")
    found = heatwright("identify plotter.log --spec chamber.yaml --json").json
    # The record's 40 W at full duty are the spec's 240 W here.
    capacity = found["parameters"]["capacity_air"]
    assert capacity["value"] == pytest.approx(400 * 240 / 40, rel=0.02)
    # A reading is 0.78 s old when it is logged, which is no dead time of the machine.
    delay = found["parameters"]["delay"]
    assert delay["low"] <= 1.0 - 0.78 <= delay["high"]
    assert list(yaml.safe_load(found["yaml"])["simulation"]["plant"]["sense"]) == ["air"]


def test_the_block_warns_where_a_record_tells_too_little(heatwright: Heatwright) -> None:
    written("short.csv", machine(noise=0.3), (40, (20, 1.0)))
    told = heatwright("identify short.csv --power 40W").out
    assert "# WARNING: the resistance body – ambient cannot be told" in told
    assert "# NOT TOLD by this record" in told


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
