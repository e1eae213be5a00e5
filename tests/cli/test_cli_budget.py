"""`check` and the project's README tell what the tolerances of parts cost, and warn of too much."""

import re
from pathlib import Path

import pytest
from rig.commands import Heatwright
from rig.firmware import EXAMPLES, files_of

from heatwright.spec import load_text

FEEDER = (EXAMPLES / "feeder.yaml").read_text(encoding="utf-8")
ASKED = "accuracy: {within: 1 K, between: 180 °C .. 250 °C}"


def warnings(heatwright: Heatwright, text: str) -> list[str]:
    Path("feeder.yaml").write_text(text, encoding="utf-8")
    found = heatwright("check --quick feeder.yaml --json").json
    return [each["reason"] for each in found["warnings"] if each["path"].endswith("accuracy")]


def test_check_warns_of_parts_that_cost_too_much(heatwright: Heatwright) -> None:
    (told,) = warnings(heatwright, FEEDER)
    assert "3.07 K at 250 °C, 1.15 K as root" in told
    assert warnings(heatwright, FEEDER.replace("within: 1 K", "within: 3.1 K")) == []
    (told,) = warnings(heatwright, FEEDER.replace("within: 1 K", "within: 3.06 K"))
    assert "3.06 K is required" in told
    assert warnings(heatwright, FEEDER.replace(ASKED, "")) == []


def test_check_warns_of_what_cannot_be_told(heatwright: Heatwright) -> None:
    text = FEEDER.replace("within: 1 K", "within: 9 K").replace("element: A, ", "")
    (told,) = warnings(heatwright, text)
    assert told == "whether 9 K is kept cannot be judged"


def test_a_worst_case_without_a_part_is_called_so(heatwright: Heatwright) -> None:
    """By `check`, its warning and the README; whole again as soon as the part is told."""
    for told, name in (("element: A, ", "worst case"), ("", "worst case of what is told")):
        text = FEEDER.replace("element: A, ", told)
        (said,) = warnings(heatwright, text)
        assert said.startswith(f"in the {name} the parts add")
        assert re.search(rf"^ {name}  ", heatwright("check --quick feeder.yaml").out, re.MULTILINE)
        assert f"| {name} |" in files_of(text)["README.md"]


@pytest.mark.parametrize("label", ["element", "R₀", "ADC", "worst case", "root of the squares"])
def test_lines_json_and_readme_have_the_same_numbers(heatwright: Heatwright, label: str) -> None:
    path = EXAMPLES / "feeder.yaml"
    lines = heatwright(f"check --quick {path}").out.splitlines()
    (shown,) = (line.split()[-5:] for line in lines if line.strip().startswith(f"{label} "))
    rows = files_of(FEEDER)["README.md"].splitlines()
    (row,) = (line for line in rows if line.startswith(f"| {label} |"))
    assert [each.strip() for each in row.split("|")[3:-1]] == shown
    budget = heatwright(f"check --quick {path} --json").json["good"][0]["budgets"]["nozzle"]
    listed = {each["part"]: each["errors"] for each in budget["parts"]}
    listed |= {"worst case": budget["worst"], "root of the squares": budget["root_of_squares"]}
    assert [f"{each:.2f}" for each in listed[label]] == shown


def test_a_controller_without_an_adc_has_no_budget(heatwright: Heatwright) -> None:
    assert "errors from its parts" not in heatwright("check --quick chamber.yaml").out
    assert "## Accuracy" not in files_of((EXAMPLES / "chamber.yaml").read_text())["README.md"]


def test_what_is_not_told_has_no_part_in_the_digest() -> None:
    (line,) = (each for each in FEEDER.splitlines() if "tolerances:" in each)
    told, empty, without = (
        load_text(FEEDER.replace(line, other).replace(ASKED, "")).digest
        for other in (line, "    tolerances: {}", "")
    )
    assert told != empty == without
    assert load_text(FEEDER).digest != told
