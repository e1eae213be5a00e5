"""The pages of every spec with a touch display: all fits, nothing overlaps, all code can be run."""

import re
from itertools import combinations
from pathlib import Path

import pytest

from heatwright.sim.interfaces.nextion_codes import LONGEST_NAME
from heatwright.sim.interfaces.nextion_display import Display
from heatwright.sim.interfaces.nextion_events import Choice, read
from heatwright.sim.interfaces.nextion_screen import font
from heatwright.spec import load
from heatwright.spec.nextion import FONTS, HEIGHT, WIDTH, Component, Page, display_pages

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"
SEEN = ("text", "number", "button", "dual_state", "waveform")
FIGURES = 12
"""Fields of so many characters or less hold figures; longer ones hold words."""
DIGITS = {"temp": 4, "set": 4, "duty": 3, "ot": 3}
"""Of numbers, where they are not days, hours, minutes or places."""
COMMAND = re.compile(rb"(#\d+( [^#;]*)?;)*")


def _displays() -> list[tuple[Page, ...]]:
    controllers = [load(path).controller for path in sorted(EXAMPLES.glob("*.yaml"))]
    return [pages for each in controllers if (pages := display_pages(each))]


DISPLAYS = _displays()
PAGES = {page.name: page for pages in DISPLAYS for page in pages}
every_page = pytest.mark.parametrize("page", PAGES.values(), ids=PAGES)


def seen(page: Page) -> list[Component]:
    return [each for each in page.components if each.kind in SEEN]


@every_page
def test_all_is_on_the_screen(page: Page) -> None:
    for each in seen(page):
        assert 0 <= each.x <= each.x + each.w <= WIDTH, each.name
        assert 0 <= each.y <= each.y + each.h <= HEIGHT, each.name


@every_page
def test_nothing_overlaps(page: Page) -> None:
    for one, other in combinations(seen(page), 2):
        beside = one.x + one.w <= other.x or other.x + other.w <= one.x
        above = one.y + one.h <= other.y or other.y + other.h <= one.y
        assert beside or above, f"{one.name} and {other.name}"


@every_page
def test_texts_fit(page: Page) -> None:
    for each in seen(page):
        if each.kind == "waveform":
            continue
        height = FONTS[int(each.attributes["font"])]
        longest = int(each.attributes.get("txt_maxl", DIGITS.get(each.name, 2)))
        text = str(each.attributes.get("txt", "")) or "0" * min(longest, FIGURES)
        assert font(height).getlength(text) <= each.w, f"{each.name}: {text}"
        assert height <= each.h, each.name


@every_page
def test_numbers_and_names(page: Page) -> None:
    assert [each.id for each in page.components] == list(range(1, len(page.components) + 1))
    names = [page.name, *(each.name for each in page.components)]
    assert all(len(name) <= LONGEST_NAME for name in names)
    assert len(set(names[1:])) == len(names) - 1


@every_page
def test_nothing_stands_behind_a_page_change(page: Page) -> None:
    """It would never be run."""

    def look(code: tuple[str | Choice, ...]) -> None:
        for number, each in enumerate(code):
            if isinstance(each, Choice):
                look(each.then)
                look(each.otherwise)
            elif each.startswith("page "):
                assert number == len(code) - 1, each

    for owner in page.components:
        for event in (owner.press, owner.release, owner.timer):
            look(read(event))


@pytest.mark.parametrize("pages", DISPLAYS, ids=lambda pages: f"{len(pages)} pages")
def test_every_touch_sends_whole_commands(pages: tuple[Page, ...]) -> None:
    """Nothing on any page ends in an error; what is printed is commands, or nothing."""
    shown = Display(pages)
    for number, page in enumerate(pages):
        for each in page.components:
            if not (each.press or each.release):
                continue
            shown.start()
            shown.show(number)
            shown.take()
            shown.press(each.name)
            shown.release()
            sent = shown.take()
            assert COMMAND.fullmatch(sent), f"{page.name}.{each.name}: {sent!r}"
            assert shown.page != page.name or b"#21" not in sent


def led_to(pages: tuple[Page, ...], path: tuple[str, ...]) -> Display:
    """A display after touches, the first of its pages, or one that the board shows."""
    shown = Display(pages)
    shown.start()
    shown.show(next(number for number, page in enumerate(pages) if page.name == path[0]))
    for name in path[1:]:
        shown.press(name)
        shown.release()
    return shown


@pytest.mark.parametrize("pages", DISPLAYS, ids=lambda pages: f"{len(pages)} pages")
def test_every_page_is_reached_and_left(pages: tuple[Page, ...]) -> None:
    """By touches alone, but for the pages of faults, which the board shows; all lead back."""
    paths = {"main": ("main",)}
    by_board = [page.name for page in pages if page.name.startswith("fault")]
    waiting = ["main"]
    while waiting or by_board:
        if not waiting:
            waiting, by_board = by_board, []
            paths |= {name: (name,) for name in waiting if name not in paths}
        name = waiting.pop()
        buttons = [each.name for each in PAGES[name].components if each.release]
        for path in ((*paths[name], touched) for touched in buttons):
            to = led_to(pages, path).page
            if to not in paths:
                paths[to] = path
                waiting.append(to)
    assert set(paths) == {page.name for page in pages}
    for name, path in paths.items():
        if name != "main":
            back = {"stop": "no"}.get(name, "back")
            assert led_to(pages, (*path, back)).page != name
