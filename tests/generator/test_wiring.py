"""The drawing of the wiring: all pins are on it, nothing stands on anything else, bytes repeat."""

from dataclasses import replace
from itertools import combinations
from typing import NamedTuple
from xml.etree import ElementTree as ET

import pytest
from rig.controllers import drawn
from rig.specs import EXAMPLES, example, files_of
from suite import amount

from heatwright.generator import plan_firmware
from heatwright.generator.plan.parts import Symbol
from heatwright.generator.wiring import drawn as wires
from heatwright.spec import Spec

NAMES = sorted(path.stem for path in EXAMPLES.glob("*.yaml"))
SVG = "{http://www.w3.org/2000/svg}"
NARROW = 0.5
"""Width of a character, at least, in heights: of DejaVu Sans, the widest that browsers take."""


class Text(NamedTuple):
    """A piece of text and the box it stands in, in points."""

    words: str
    left: float
    top: float
    right: float
    bottom: float


def texts(svg: str) -> list[Text]:
    found = []
    for each in ET.fromstring(svg).iter(f"{SVG}text"):  # noqa: S314 - our own
        words = "".join(each.itertext()).strip()
        height = float(each.get("font-size", "0").removesuffix("px").removesuffix("pt"))
        width = len(words) * height * NARROW
        left = float(each.get("x", "0"))
        left -= {"middle": width / 2, "end": width}.get(each.get("text-anchor", ""), 0.0)
        bottom = float(each.get("y", "0"))
        bottom += 0.35 * height * (each.get("dominant-baseline") == "central")
        found.append(Text(words, left, bottom - 0.7 * height, left + width, bottom))
    return found


def overlapping(found: list[Text]) -> list[tuple[str, str]]:
    return [
        (a.words, b.words)
        for a, b in combinations(found, 2)
        if a.left < b.right and b.left < a.right and a.top < b.bottom and b.top < a.bottom
    ]


def pins(spec: Spec) -> set[str]:
    """Return the pins that the firmware has functions for, and those in the table of the README."""
    files = {file.path: file.told for file in plan_firmware(spec).files}
    used = {pin.label.partition(" = ")[0] for pin in files["src/pins.h"].pins}
    told = {word for row in files["README.md"].wiring for word in row.pin.split()}
    assert used <= told, "a pin is missing in the README's table"
    return used


@pytest.mark.parametrize("name", NAMES)
def test_every_pin_is_drawn_and_no_text_stands_on_another(name: str) -> None:
    found = texts(files_of(name)["wiring.svg"])
    assert pins(example(name)) <= {word for text in found for word in text.words.split()}
    assert overlapping(found) == []


def test_overlapping_text_would_be_seen() -> None:
    svg = f'<svg xmlns="{SVG[1:-1]}"><text x="0" y="9" font-size="10">abc</text>{{}}</svg>'
    other = '<text x="{}" y="9" font-size="10">def</text>'
    assert overlapping(texts(svg.format(other.format(14)))) == [("abc", "def")]
    assert overlapping(texts(svg.format(other.format(16)))) == []


def test_every_pin_of_drawn_controllers_is_in_the_table() -> None:
    for each in drawn(amount("drawn_models")):
        pins(each.spec)


def test_the_readme_shows_it() -> None:
    assert "](wiring.svg)" in files_of("kiln")["README.md"]


@pytest.mark.parametrize("name", NAMES)
def test_no_text_is_cut_off_at_the_edge(name: str) -> None:
    svg = files_of(name)["wiring.svg"]
    left, _, width, _ = map(float, ET.fromstring(svg).attrib["viewBox"].split())  # noqa: S314
    assert max(each.right for each in texts(svg)) <= left + width


def test_a_contact_that_is_closed_while_all_is_well_is_drawn_closed() -> None:
    rows = [row for rows in plan_firmware(example("kiln")).wiring.values() for row in rows]
    (mirror,) = (row for row in rows if row.how.startswith("its mirror contact"))
    assert [symbol.shape for symbol in mirror.symbols] == ["closed"]
    symbol = Symbol("down", "contact", "mirror contact, normally closed")
    opened = replace(mirror, symbols=(symbol,))
    assert wires("kiln", "mega2560", [mirror]) != wires("kiln", "mega2560", [opened])
