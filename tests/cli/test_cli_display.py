"""A touch display, seen from the command line: its page as a picture, and in the report."""

import re
from pathlib import Path

import pytest
from conftest import EXAMPLES, Heatwright

KILN = EXAMPLES / "kiln.yaml"
PNG = b"\x89PNG\r\n\x1a\n"


def test_the_page_is_drawn(heatwright: Heatwright) -> None:
    done = heatwright("simulate", KILN, "--for", "10 s", "--display", "k.png", "--plot", "k.html")
    assert done.status == 0
    assert "k.png" in done.out.splitlines()
    assert Path("k.png").read_bytes().startswith(PNG)
    page = Path("k.html").read_text(encoding="utf-8")
    assert len(re.findall(r'<img class="screen" src="data:image/png;base64,[\w+/]+=*"', page)) == 1


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("chamber.yaml", "--display", "k.png"), "There is no touch display to draw"),
        ((KILN, "--display", "k.png", "--model"), "The model has no display"),
        ((KILN, "--display", "k.jpg"), "name it with .png"),
        ((KILN, "--display", "k.png", "--serial"), "--serial goes with"),
    ],
)
def test_what_cannot_be_drawn(
    heatwright: Heatwright, words: tuple[str | Path, ...], why: str
) -> None:
    done = heatwright("simulate", *words)
    assert done.status == 2
    assert why in done.err
    assert not Path("k.png").exists()


def test_a_plain_shield_has_no_picture(heatwright: Heatwright) -> None:
    assert heatwright("simulate", "chamber.yaml", "--for", "5 s", "--plot", "c.html").status == 0
    assert "<img" not in Path("c.html").read_text(encoding="utf-8")
