"""A display of two pages, with something of every kind."""

from collections.abc import Mapping
from typing import Any

from heatwright.sim.interfaces.nextion_display import Display
from heatwright.spec.nextion import Component, Page

FIRST = (
    Component("text", "t0", 1, 20, 20, 200, 60, {"txt": "", "txt_maxl": 10, "font": 1}),
    Component("number", "n0", 2, 600, 300, 100, 40, {"val": 0, "font": 0}, shared=True),
    Component("number", "n1", 3, 600, 350, 100, 40, {"val": 4, "font": 0}),
    Component("dual_state", "bt1", 4, 600, 400, 100, 40, {"txt": "on", "txt_maxl": 3, "font": 0},
              release=("if(bt1.val==1)", "{", 'print "#9 1;"', "}else", "{", 'print "#9 0;"', "}")),
    Component("button", "b0", 5, 600, 120, 160, 70, {"txt": "go", "txt_maxl": 3, "font": 0},
              press=("n1.val+=2",), release=("covx n1.val,t0.txt,3,0", "print t0.txt")),
    Component("button", "b1", 6, 600, 200, 160, 70, {"txt": "away", "txt_maxl": 5, "font": 0},
              release=("page away", "n0.val=99")),
    Component("waveform", "s0", 7, 20, 120, 40, 100, {"ch": 2, "gdw": 20, "gdh": 20}),
    Component("timer", "tm0", 8, attributes={"tim": 100, "en": 0}, timer=("n1.val++",)),
    Component("variable", "va0", 9, attributes={"sta": 1, "txt": "", "txt_maxl": 4}, shared=True),
)  # fmt: skip
SECOND = (
    Component("text", "t0", 1, 0, 0, 800, 480, {"txt": "away", "txt_maxl": 10, "font": 1}),
    Component("number", "n0", 2, attributes={"val": 7}),
)
PAGES = (
    Page("first", 0, FIRST, postinitialize=('print "#21 0;"',)),
    Page("away", 1, SECOND, ("n0.val+=1",), ('print "#21 1;"',)),
)
STARTED = b"\0\0\0\xff\xff\xff#21 0;\x88\xff\xff\xff"


def display(*pages: Page) -> Display:
    """Return a display that has started, and said so."""
    made = Display(pages or PAGES)
    made.start()
    made.take()
    return made


def page_of(*components: Component, name: str = "only", **events: Any) -> Page:
    return Page(name, 0, components, **events)


def tell(shown: Display, *instructions: str) -> bytes:
    """Send instructions; return what it answers."""
    for each in instructions:
        shown.receive(each.encode("latin-1") + b"\xff\xff\xff")
    return shown.take()


def button(name: str, *release: str, attributes: Mapping[str, int | str] | None = None,
           place: tuple[int, int] = (0, 0)) -> Component:  # fmt: skip
    own = {"txt": name, "txt_maxl": 14, "font": 0, **(attributes or {})}
    return Component("button", name, 1, *place, 100, 50, own, release=release)
