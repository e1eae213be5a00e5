"""What a page of a Nextion display is made of, in the words of its editor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

Kind = Literal["text", "number", "button", "dual_state", "waveform", "timer", "variable"]
Code = tuple[str, ...]
"""The lines of an event, as they are typed into the editor."""
Attribute = int | str

WIDTH, HEIGHT = 800, 480
"""Pixels of an NX8048T050."""

FONTS = (24, 32, 80)
"""Heights of the fonts in pixels, by their numbers in the editor."""
SMALL, LARGE, HUGE = range(3)

BLACK, WHITE, GREY, DARK = 0x0000, 0xFFFF, 0x8410, 0x2104
RED, GREEN, BLUE, AMBER = 0xC000, 0x0400, 0x0010, 0xFD20
"""Colours of 16 bits: five red, six green, five blue."""

NO_ATTRIBUTES: Mapping[str, Attribute] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Component:
    """One component of a page: where it is, what it begins with, what it does when touched."""

    kind: Kind
    name: str
    id: int
    x: int = 0
    y: int = 0
    w: int = 0
    h: int = 0
    attributes: Mapping[str, Attribute] = field(default_factory=lambda: NO_ATTRIBUTES)
    press: Code = ()
    release: Code = ()
    timer: Code = ()
    shared: bool = False
    """Of scope `global`: it keeps its values while another page is shown, and is set from there."""


@dataclass(frozen=True, slots=True)
class Page:
    """One page; its number is its place in the editor's list."""

    name: str
    id: int
    components: tuple[Component, ...]
    preinitialize: Code = ()
    postinitialize: Code = ()
    bco: int = BLACK
    meaning: str = ""
    """What it is for, in a line."""


@dataclass(slots=True)
class Sheet:
    """Lays a page out: components get their numbers in the order in which they are added."""

    name: str
    id: int
    meaning: str
    components: list[Component] = field(default_factory=list)

    def add(  # noqa: PLR0913 - a rectangle has four numbers
        self,
        kind: Kind,
        name: str,
        place: tuple[int, int, int, int] = (0, 0, 0, 0),
        attributes: Mapping[str, Attribute] = NO_ATTRIBUTES,
        *,
        press: Code = (),
        release: Code = (),
        timer: Code = (),
        shared: bool = False,
    ) -> None:
        """Add a component at x, y, w, h."""
        x, y, w, h = place
        number = len(self.components) + 1
        self.components.append(
            Component(
                kind, name, number, x, y, w, h,
                MappingProxyType(dict(attributes)), press, release, timer, shared,
            )
        )  # fmt: skip

    def label(self, name: str, place: tuple[int, int, int, int], text: str, font: int = 0) -> None:
        """Add a text that never changes."""
        self.add("text", name, place, text_attributes(text, len(text), font))

    def text(  # noqa: PLR0913 - what differs between texts
        self,
        name: str,
        place: tuple[int, int, int, int],
        longest: int,
        font: int = SMALL,
        *,
        release: Code = (),
        shared: bool = False,
        pco: int = WHITE,
    ) -> None:
        """Add a text of at most `longest` characters that begins empty."""
        self.add(
            "text", name, place, text_attributes("", longest, font) | {"pco": pco},
            release=release, shared=shared,
        )  # fmt: skip

    def number(
        self, name: str, place: tuple[int, int, int, int], font: int = LARGE, *, shared: bool = True
    ) -> None:
        """Add a whole number that begins with 0."""
        attributes = {"val": 0, "font": font, "pco": WHITE, "bco": BLACK}
        self.add("number", name, place, attributes, shared=shared)

    def button(
        self, name: str, place: tuple[int, int, int, int], text: str, code: Code, bco: int = DARK
    ) -> None:
        """Add a button that does something when the finger leaves it."""
        attributes = text_attributes(text, max(len(text), 1), SMALL) | {"bco": bco, "bco2": GREY}
        self.add("button", name, place, attributes | {"xcen": 1}, release=code)

    def variable(self, name: str) -> None:
        """Add a whole number that is not seen."""
        self.add("variable", name, attributes={"sta": 0, "val": 0}, shared=True)

    def words(self, name: str, longest: int) -> None:
        """Add a text that is not seen."""
        self.add("variable", name, attributes={"sta": 1, "txt": "", "txt_maxl": longest})

    def page(self, *, preinitialize: Code = ()) -> Page:
        """Return the page; whenever it is shown it says so."""
        shown = (f'print "#21 {self.id};"',)
        return Page(
            self.name, self.id, tuple(self.components), preinitialize, shown, meaning=self.meaning
        )


def text_attributes(text: str, longest: int, font: int) -> dict[str, Attribute]:
    """Attributes of what shows a text, white on black."""
    return {
        "txt": text, "txt_maxl": longest, "font": font, "pco": WHITE, "bco": BLACK,
        "xcen": 0, "ycen": 1,
    }  # fmt: skip
