"""simulate and compare, with the model: figures, files, options."""

import csv
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from rig.commands import Heatwright, changed
from rig.specs import EXAMPLES

PNG = b"\x89PNG\r\n\x1a\n"


def test_a_run_is_told_in_figures(heatwright: Heatwright) -> None:
    done = heatwright("simulate chamber.yaml --model")
    assert "setpoint [°C]" in done.out
    assert "30 min simulated in" in done.out
    assert done.err == "Simulating the model …\n"


def test_a_run_as_json(heatwright: Heatwright) -> None:
    found = heatwright("simulate chamber.yaml --model --json").json
    assert (found["spec"], found["device"]) == ("chamber.yaml", "model")
    assert found["loops"]["air"]["closed_loop"]["maximum"] == 50.5
    assert found["loops"]["air"]["faults"] == []
    assert found["display"] is None
    assert found["speed"]["simulated_s"] == pytest.approx(1800, abs=1)


def test_another_length(heatwright: Heatwright) -> None:
    longer = heatwright("simulate chamber.yaml --model --for 1h --json").json
    assert longer["speed"]["simulated_s"] == pytest.approx(3600, abs=1)
    shorter = heatwright("simulate chamber.yaml --model --for '5 s' --json").json
    assert shorter["loops"]["air"]["closed_loop"]["maximum"] == 20, "the key comes after the end"


def test_another_scenario(heatwright: Heatwright) -> None:
    Path("cold.yaml").write_text(
        "scenario:\n  - {at: 1 s, press: down}\n  - {for: 2 min}\n", encoding="utf-8"
    )
    found = heatwright("simulate chamber.yaml --model --json --scenario cold.yaml").json
    assert found["speed"]["simulated_s"] == pytest.approx(120, abs=1)
    assert found["loops"]["air"]["closed_loop"]["energy_J"] == 0


def test_csv_has_units_and_every_step(heatwright: Heatwright) -> None:
    heatwright("simulate chamber.yaml --model --csv run.csv")
    with Path("run.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert header[:3] == ["time [s]", "element [°C]", "air [°C]"]
    assert "air.temperature_c [°C]" in header
    assert len(rows) == 9002
    assert float(rows[-1][0]) == pytest.approx(1800.2)


def test_pictures_are_of_their_kinds(heatwright: Heatwright) -> None:
    for name in ("run.png", "run.svg", "run.html"):
        done = heatwright(f"simulate chamber.yaml --model --for 2min --plot {name}")
        assert done.out.splitlines()[-1] == name
    assert Path("run.png").read_bytes().startswith(PNG)
    assert ET.parse("run.svg").getroot().tag.endswith("svg")  # noqa: S314 - our own
    page = Path("run.html").read_text(encoding="utf-8")
    assert page.startswith("<!doctype html>")
    assert "http" not in page.replace("http://www.w3.org", ""), "it needs nothing else"


@pytest.mark.parametrize(
    ("title", "picture"),
    [
        ("</title></script><script>alert(1)</script>", "run.html"),
        ("[bold]$\\frac{1}$ ^_", "run.svg"),
    ],
)
def test_text_of_the_spec_stays_text(heatwright: Heatwright, title: str, picture: str) -> None:
    spec = changed("chamber", "Air heater for a 3D-printer enclosure", f"'{title}'", count=2)
    heatwright(f"simulate {spec} --model --for 1min --plot {picture}")
    assert "<script>alert" not in Path(picture).read_text(encoding="utf-8")


def test_a_touch_display_is_drawn(heatwright: Heatwright) -> None:
    kiln = EXAMPLES / "kiln.yaml"
    done = heatwright(f"simulate {kiln} --for 10s --display k.png --plot k.html")
    assert "k.png" in done.out.splitlines()
    assert Path("k.png").read_bytes().startswith(PNG)
    page = Path("k.html").read_text(encoding="utf-8")
    assert len(re.findall(r'<img class="screen" src="data:image/png;base64,[\w+/]+=*"', page)) == 1


def test_a_plain_shield_has_no_picture(heatwright: Heatwright) -> None:
    heatwright("simulate chamber.yaml --for 5s --plot c.html")
    assert "<img" not in Path("c.html").read_text(encoding="utf-8")


def test_a_comparison_stands_beside_the_published_figures(heatwright: Heatwright) -> None:
    told = heatwright("compare oven.yaml --model --algorithm relay --plot c.png").out
    ours, published = [line for line in told.splitlines() if "50 °C" in line or "publ" in line]
    assert ours.split()[:4] == ["relay,", "50", "°C", "52.31"]
    assert published.split()[:3] == ["published", "52.20", "+2.20"]
    assert Path("c.png").read_bytes().startswith(PNG)


def test_a_comparison_as_json_and_as_a_page(heatwright: Heatwright) -> None:
    found = heatwright("compare oven.yaml --model --algorithm pid --json --plot c.html").json
    assert {"proportional", "PID"} <= {row["name"] for row in found["rows"]}
    row = found["rows"][0]
    assert row["published"] == {"maximum": 50.5, "steady_min": 48.7, "steady_max": 49.2}
    assert (row["build"], row["replay"], row["audible"]) == (None, None, True)
    assert "figure class=" in Path("c.html").read_text(encoding="utf-8")
