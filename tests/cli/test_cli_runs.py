"""simulate and compare, with the model: figures, files, options."""

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
    found = heatwright("simulate chamber.yaml --model --json").json
    assert (found["spec"], found["device"]) == ("chamber.yaml", "model")
    assert found["loops"]["air"]["closed_loop"]["maximum"] == 50.5
    assert found["loops"]["air"]["faults"] == []
    assert found["display"] is None


@pytest.mark.parametrize(
    ("words", "length_s", "figures"),
    [
        ("--for 40min", 2400, {}),
        ("--for '5 s'", 5, {"maximum": 20}),  # the key is pressed after the end
        ("--scenario cold.yaml", 120, {"energy_J": 0}),
        ("--scenario cold.yaml --for 1min", 60, {"energy_J": 0}),
    ],
)
def test_what_is_done_and_for_how_long(
    heatwright: Heatwright, words: str, length_s: float, figures: dict[str, float]
) -> None:
    cold = "scenario:\n  - {at: 1 s, press: down}\n  - {for: 2 min}\n"
    Path("cold.yaml").write_text(cold, encoding="utf-8")
    found = heatwright(f"simulate chamber.yaml --model --json {words}").json
    assert found["speed"]["simulated_s"] == pytest.approx(length_s, abs=1)
    assert figures.items() <= found["loops"]["air"]["closed_loop"].items()


def drawn(heatwright: Heatwright, title: str, picture: str) -> str:
    """Draw a run of the chamber, under another title."""
    spec = changed("chamber", "Air heater for a 3D-printer enclosure", f"'{title}'", count=2)
    done = heatwright(f"simulate {spec} --model --for 1min --plot {picture}")
    assert done.out.splitlines()[-1] == picture
    return "" if picture.endswith("png") else Path(picture).read_text(encoding="utf-8")


def test_pictures_are_of_their_kinds_and_text_stays_text(heatwright: Heatwright) -> None:
    mathematics = "[bold]$\\frac{1}$ ^_"
    drawn(heatwright, mathematics, "run.png")
    assert Path("run.png").read_bytes().startswith(PNG)
    root = ET.fromstring(drawn(heatwright, mathematics, "run.svg"))  # noqa: S314 - our own
    assert root.tag.endswith("svg")
    page = drawn(heatwright, "</title></script><script>alert(1)</script>", "run.html")
    assert page.startswith("<!doctype html>")
    assert "<script>alert" not in page
    assert "http" not in page.replace("http://www.w3.org", ""), "it needs nothing else"


def test_a_touch_display_is_drawn_and_a_plain_shield_is_not(heatwright: Heatwright) -> None:
    heatwright("simulate chamber.yaml --for 5s --plot c.html")
    assert "<img" not in Path("c.html").read_text(encoding="utf-8")
    done = heatwright(f"simulate {EXAMPLES}/kiln.yaml --for 5s --display k.png --plot k.html")
    assert "k.png" in done.out.splitlines()
    assert Path("k.png").read_bytes().startswith(PNG)
    page = Path("k.html").read_text(encoding="utf-8")
    assert len(re.findall(r'<img class="screen" src="data:image/png;base64,[\w+/]+=*"', page)) == 1


def test_a_comparison_stands_beside_the_published_figures(heatwright: Heatwright) -> None:
    told = heatwright("compare oven.yaml --model --algorithm relay").out
    ours, published = [line for line in told.splitlines() if "50 °C" in line or "publ" in line]
    assert ours.split()[:4] == ["relay,", "50", "°C", "52.31"]
    assert published.split()[:3] == ["published", "52.20", "+2.20"]


def test_a_comparison_as_json_and_as_a_page(heatwright: Heatwright) -> None:
    found = heatwright("compare oven.yaml --model --algorithm pid --json --plot c.html").json
    assert {"proportional", "PID"} <= {row["name"] for row in found["rows"]}
    row = found["rows"][0]
    assert row["published"] == {"maximum": 50.5, "steady_min": 48.7, "steady_max": 49.2}
    assert (row["build"], row["replay"], row["audible"]) == (None, None, True)
    assert "figure class=" in Path("c.html").read_text(encoding="utf-8")
