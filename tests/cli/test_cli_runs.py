"""simulate and compare, with the model: figures, files, options."""

import csv
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from conftest import Heatwright


def test_a_run_is_told_in_figures(heatwright: Heatwright) -> None:
    done = heatwright("simulate", "chamber.yaml", "--model")
    assert done.status == 0
    assert "setpoint [°C]" in done.out
    assert "30 min simulated in" in done.out
    assert done.err == "Simulating the model …\n"


def test_a_run_as_json(heatwright: Heatwright) -> None:
    found = heatwright("simulate", "chamber.yaml", "--model", "--json").json
    assert (found["spec"], found["device"]) == ("chamber.yaml", "model")
    assert found["loops"]["air"]["closed_loop"]["maximum"] == 50.5
    assert found["loops"]["air"]["faults"] == []
    assert found["display"] is None
    assert found["speed"]["simulated_s"] == pytest.approx(1800, abs=1)


def test_another_length(heatwright: Heatwright) -> None:
    longer = heatwright("simulate", "chamber.yaml", "--model", "--for", "1h", "--json").json
    assert longer["speed"]["simulated_s"] == pytest.approx(3600, abs=1)
    shorter = heatwright("simulate", "chamber.yaml", "--model", "--for", "5 s", "--json").json
    assert shorter["loops"]["air"]["closed_loop"]["maximum"] == 20, "the key comes after the end"


def test_another_scenario(heatwright: Heatwright) -> None:
    Path("cold.yaml").write_text(
        "scenario:\n  - {at: 1 s, press: down}\n  - {for: 2 min}\n", encoding="utf-8"
    )
    words = ("simulate", "chamber.yaml", "--model", "--json", "--scenario", "cold.yaml")
    found = heatwright(*words).json
    assert found["speed"]["simulated_s"] == pytest.approx(120, abs=1)
    assert found["loops"]["air"]["closed_loop"]["energy_J"] == 0


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "bad.yaml:1:1: there is no scenario in this file. Write scenario: [ … ]."),
        ("scenario: 1\n", "bad.yaml:1:1: scenario: a list is needed here"),
        ("- {for: 1 h}\n", "bad.yaml:1:1: keys and values are needed here"),
        ("scenario:\n  - {for: 1}\n", "bad.yaml:2:6: scenario[0].for: 1 has no unit"),
        ("scenario:\n  - {at: 1 s, press: up}\n", "bad.yaml:1:1: scenario: "),
        ("scenario: [", "bad.yaml:1:1"),
        ("scenario: []\nother: 1\n", "bad.yaml:2:1: other: there is no such key"),
    ],
)
def test_a_bad_scenario_is_refused_with_its_lines(
    heatwright: Heatwright, text: str, expected: str
) -> None:
    Path("bad.yaml").write_text(text, encoding="utf-8")
    done = heatwright("simulate", "chamber.yaml", "--model", "--scenario", "bad.yaml")
    assert (done.status, done.out) == (2, "")
    assert done.err.startswith(expected)


def test_csv_has_units_and_every_step(heatwright: Heatwright) -> None:
    assert heatwright("simulate", "chamber.yaml", "--model", "--csv", "run.csv").status == 0
    with Path("run.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert header[:3] == ["time [s]", "element [°C]", "air [°C]"]
    assert "air.temperature_c [°C]" in header
    assert len(rows) == 9002
    assert float(rows[-1][0]) == pytest.approx(1800.2)


def test_pictures_are_of_their_kinds(heatwright: Heatwright) -> None:
    for name in ("run.png", "run.svg", "run.html"):
        done = heatwright("simulate", "chamber.yaml", "--model", "--for", "2min", "--plot", name)
        assert done.status == 0
        assert done.out.splitlines()[-1] == name
    assert Path("run.png").read_bytes().startswith(b"\x89PNG")
    assert ET.parse("run.svg").getroot().tag.endswith("svg")  # noqa: S314 - our own
    page = Path("run.html").read_text(encoding="utf-8")
    assert page.startswith("<!doctype html>")
    assert "http" not in page.replace("http://www.w3.org", ""), "it needs nothing else"


def test_text_of_the_spec_stays_text_in_a_page(heatwright: Heatwright) -> None:
    spec = Path("chamber.yaml").read_text(encoding="utf-8")
    title = "</title></script><script>alert(1)</script>"
    Path("evil.yaml").write_text(
        spec.replace("Air heater for a 3D-printer enclosure", f'"{title}"', 2), encoding="utf-8"
    )
    words = ("simulate", "evil.yaml", "--model", "--for", "1min", "--plot", "evil.html")
    assert heatwright(*words).status == 0
    assert "<script>alert" not in Path("evil.html").read_text(encoding="utf-8")


def test_text_of_the_spec_stays_text_in_a_picture(heatwright: Heatwright) -> None:
    spec = Path("chamber.yaml").read_text(encoding="utf-8")
    title = "[bold]$\\frac{1}$ ^_"
    Path("odd.yaml").write_text(
        spec.replace("Air heater for a 3D-printer enclosure", f"'{title}'", 2), encoding="utf-8"
    )
    words = ("simulate", "odd.yaml", "--model", "--for", "1min", "--plot", "odd.svg")
    assert heatwright(*words).status == 0


def test_a_failing_run_keeps_the_files_that_were_there(heatwright: Heatwright) -> None:
    Path("run.csv").write_text("precious", encoding="utf-8")
    words = ("simulate", "chamber.yaml", "--model", "--scenario", "none.yaml", "--csv", "run.csv")
    assert heatwright(*words).status == 2
    assert Path("run.csv").read_text(encoding="utf-8") == "precious"
    assert sorted(path.name for path in Path().iterdir()) == [
        "chamber.yaml", "oven.yaml", "run.csv",
    ]  # fmt: skip


def test_a_comparison_stands_beside_the_published_figures(heatwright: Heatwright) -> None:
    done = heatwright("compare", "oven.yaml", "--model", "--algorithm", "relay", "--plot", "c.png")
    assert done.status == 0
    ours, published = [line for line in done.out.splitlines() if "50 °C" in line or "publ" in line]
    assert ours.split()[:4] == ["relay,", "50", "°C", "52.31"]
    assert published.split()[:3] == ["published", "52.20", "+2.20"]
    assert Path("c.png").read_bytes().startswith(b"\x89PNG")


def test_a_comparison_as_json_and_as_a_page(heatwright: Heatwright) -> None:
    words = ("compare", "oven.yaml", "--model", "--algorithm", "pid", "--json", "--plot", "c.html")
    done = heatwright(*words)
    assert done.status == 0
    names = [row["name"] for row in done.json["rows"]]
    assert {"proportional", "PID"} <= set(names)
    row = done.json["rows"][0]
    assert row["published"] == {"maximum": 50.5, "steady_min": 48.7, "steady_max": 49.2}
    assert (row["build"], row["replay"]) == (None, None)
    assert row["audible"] is True
    assert "figure class=" in Path("c.html").read_text(encoding="utf-8")
