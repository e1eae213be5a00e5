"""The pages of programs: their choice, and the segments of one."""

from heatwright.spec.nextion.parts import AMBER, GREEN, LARGE, SMALL, Page, Sheet, text_attributes
from heatwright.spec.programs import LONGEST_NAME

ROWS = 10
"""Segments on a page; a program with more has a second one."""
LONGEST_NUMBER = 9
"""Maximum number of characters of a time, a rate or a temperature, such as 44640.25."""


def programs_page(number: int, places: int) -> Page:
    """Lay out the choice of a program."""
    sheet = Sheet("programs", number, "Choice of a program.")
    sheet.label("title", (10, 5, 400, 40), "Programs", LARGE)
    for place in range(1, places + 1):
        y = 50 + 52 * (place - 1)
        sheet.label(f"no{place}", (10, y, 40, 46), f"{place}", LARGE)
        sheet.text(f"name{place}", (60, y, 260, 46), LONGEST_NAME, LARGE)
        sheet.button(f"b{place}", (340, y, 180, 46), "segments", (f'print "#13 {place};"',))
        start = (f'print "#8 {place};"', "page main")
        sheet.button(f"s{place}", (540, y, 120, 46), "start", start, GREEN)
    sheet.button("back", (690, 420, 100, 55), "back", ("page main",))
    return sheet.page()


def points_page(number: int, first: int, points: int, *, more: str) -> Page:
    """Lay out the segments from `first` on. more -- the next page of segments, or empty."""
    name = "points" if first == 1 else "points2"
    sheet = Sheet(name, number, f"Segments {first} to {min(points, first + ROWS - 1)}.")
    sheet.number("programm", (10, 5, 40, 36), SMALL, shared=False)
    entry = ("name.show.txt=pname.txt", "page name")
    sheet.text("pname", (60, 5, 220, 36), LONGEST_NAME, LARGE, release=entry)
    for place in range(first, min(points, first + ROWS - 1) + 1):
        _row(sheet, place, 46 + 43 * (place - first))
    if more:
        sheet.button("more", (690, 300, 100, 50), "more", (f"page {more}",))
    sheet.button("back", (690, 420, 100, 55), "back", ("page main",))
    return sheet.page()


def _row(sheet: Sheet, place: int, y: int) -> None:
    """Add one segment: number (a touch selects it), kind, time or rate, end, button to jump."""
    edit = (
        f"point.n.val={place}",
        f"point.k.txt=k{place}.txt",
        f"point.m.txt=m{place}.txt",
        f"point.t.txt=t{place}.txt",
        "page point",
    )
    mark = text_attributes(f"{place}", 2, SMALL) | {"xcen": 1}
    sheet.add("text", f"p{place}", (10, y, 46, 38), mark, release=(f'print "#11 {place};"',))
    sheet.text(f"k{place}", (70, y, 90, 38), 5, release=edit)
    sheet.text(f"m{place}", (170, y, 150, 38), LONGEST_NUMBER, release=edit)
    sheet.text(f"t{place}", (330, y, 150, 38), LONGEST_NUMBER, release=edit, pco=AMBER)
    go = (f'print "#10 {place};"', "page main")
    sheet.button(f"g{place}", (500, y, 130, 38), "go here", go)
