"""What the simulated display draws, pixel by pixel where it matters."""

from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from small_pages import PAGES, button, display, page_of, tell

from heatwright.sim.interfaces.nextion_colours import rgb
from heatwright.sim.interfaces.nextion_display import Display
from heatwright.sim.interfaces.nextion_screen import draw, png
from heatwright.spec.nextion import Component

WHITE, RED, GREEN, BLUE = 0xFFFF, 0xF800, 0x07E0, 0x001F


def pixels(shown: Display) -> np.ndarray:
    return np.asarray(draw(shown))


def inked(shown: Display, colour: int) -> np.ndarray:
    """Where a colour is: rows and columns."""
    return np.argwhere((pixels(shown) == rgb(colour)).all(axis=2))


def test_colours_of_sixteen_bits_and_dark_without_power() -> None:
    colours = (0, 0, 0), (255, 255, 255), (255, 0, 0), (0, 255, 0), (0, 0, 255)
    assert tuple(map(rgb, (0, WHITE, RED, GREEN, BLUE))) == colours
    assert not pixels(Display(PAGES)).any()


def test_a_component_is_where_the_editor_put_it() -> None:
    text = Component("text", "t0", 1, 30, 40, 100, 50, {"txt": "", "bco": RED, "font": 0})
    found = inked(display(page_of(text, bco=BLUE)), RED)
    assert (found.min(axis=0) == (40, 30)).all()
    assert (found.max(axis=0) == (89, 129)).all()


@pytest.mark.parametrize(("across", "down"), [(0, 0), (1, 1), (2, 2)])
def test_text_stands_where_it_is_asked_to(across: int, down: int) -> None:
    own = {"txt": "Hg", "txt_maxl": 2, "font": 0, "xcen": across, "ycen": down}
    colours = {"bco": WHITE, "pco": RED}
    found = inked(display(page_of(Component("text", "t0", 1, 0, 0, 300, 200, own | colours))), RED)
    middle = found.mean(axis=0)
    for at, where, size in zip(middle, (down, across), (200, 300), strict=True):
        assert (at < 30, abs(at - size / 2) < 5, at > size - 30)[where]


def test_text_is_cut_at_its_component() -> None:
    own = {"txt": "M" * 20, "txt_maxl": 20, "font": 2, "bco": WHITE, "pco": RED}
    found = inked(display(page_of(Component("text", "t0", 1, 50, 50, 60, 20, own))), RED)
    assert len(found)
    assert (found.min(axis=0) >= (50, 50)).all()
    assert (found.max(axis=0) < (70, 110)).all()


def test_a_button_shows_the_finger_and_nothing_while_it_is_hidden() -> None:
    shown = display(page_of(button("b0", attributes={"bco": RED, "bco2": GREEN})))

    def seen() -> list[bool]:
        return [bool(len(inked(shown, colour))) for colour in (RED, GREEN)]

    assert seen() == [True, False]
    shown.press("b0")
    assert seen() == [False, True]
    shown.release()
    assert seen() == [True, False]
    tell(shown, "vis b0,0")
    assert seen() == [False, False]


def test_a_switch_shows_its_state() -> None:
    own = {"txt": "", "val": 0, "bco0": RED, "bco1": GREEN}
    shown = display(page_of(Component("dual_state", "bt0", 1, 0, 0, 100, 50, own)))
    assert len(inked(shown, RED)) == 5000
    tell(shown, "bt0.val=1")
    assert len(inked(shown, GREEN)) == 5000


def test_later_components_lie_over_earlier() -> None:
    parts = [
        Component("text", f"t{n}", n, at, at, 100, 100, {"txt": "", "font": 0, "bco": colour})
        for n, at, colour in ((2, 50, GREEN), (1, 0, RED))
    ]
    shown = display(page_of(*parts))
    assert (len(inked(shown, GREEN)), len(inked(shown, RED))) == (10_000, 7_500)


def test_a_curve_is_as_high_as_its_points() -> None:
    own = {"ch": 2, "gdw": 0, "gdh": 0, "bco": 0, "pco0": RED, "pco1": GREEN}
    shown = display(page_of(Component("waveform", "s0", 1, 100, 100, 50, 80, own), bco=BLUE))
    tell(shown, "add 1,0,30")
    assert inked(shown, RED).tolist() == [[179 - 30, 100]]
    tell(shown, *["add 1,0,30"] * 49, *["add 1,1,200"] * 50)
    rows, columns = inked(shown, RED).T
    assert (columns.min(), columns.max()) == (100, 149)
    assert set(rows) <= {148, 149, 150}
    assert inked(shown, GREEN)[:, 0].min() == 100  # what is too high stays at the edge


def test_a_grid_begins_at_the_lower_left() -> None:
    own = {"gdw": 20, "gdh": 30, "gdc": RED, "bco": 0}
    found = inked(display(page_of(Component("waveform", "s0", 1, 100, 100, 50, 80, own))), RED)
    rows, columns = (np.unique(each, return_counts=True) for each in found.T)
    assert [row for row, many in zip(*rows, strict=True) if many == 50] == [119, 149, 179]
    assert [column for column, many in zip(*columns, strict=True) if many == 80] == [100, 120, 140]


def test_a_page_is_a_png() -> None:
    shown = display()
    with Image.open(BytesIO(png(shown))) as read:
        assert (read.format, read.size) == ("PNG", (800, 480))
        assert (np.asarray(read) == pixels(shown)).all()
