"""The parts of a Nextion display's page, named as in its editor."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

Kind = Literal["page", "text", "number", "button", "dual_state", "waveform", "timer", "variable"]
Code = tuple[str, ...]
"""The code of an event: lines that are typed into the editor."""
Attribute = int | str

WIDTH, HEIGHT = 800, 480
"""Size of the display NX8048T050 in pixels."""

FONTS = (24, 32, 80)
"""Heights of the fonts in pixels, by their numbers in the editor."""
SMALL, LARGE, HUGE = range(3)

WHITE, DIM = 0xFFFF, 0xA577
GROUND, FIELD, GRID = 0x10A3, 0x2146, 0x31A8
BUTTON, HELD = 0x3A2A, 0x7C75
RED, GREEN, AMBER, LIME = 0xC0E3, 0x1C09, 0xFD20, 0x766E
"""Colours of 16 bits: five red, six green, five blue."""
BUTTON_STYLE = {"xcen": 1, "style": 0}
"""Text in the middle, flat."""
CENTRED = 12
"""Texts of up to this many characters are centred in their fields, longer ones are at the left."""

NO_ATTRIBUTES: Mapping[str, Attribute] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Component:
    """One component of a page: its place, its initial attributes, and its code for a touch."""

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
    """Scope `global`: it keeps its values while another page is shown; that page can set them."""


@dataclass(frozen=True, slots=True)
class Page:
    """One page; its number is its place in the editor's list."""

    name: str
    id: int
    components: tuple[Component, ...]
    preinitialize: Code = ()
    postinitialize: Code = ()
    bco: int = GROUND
    meaning: str = ""
    """Purpose of the page, in a line."""


@dataclass(slots=True)
class Sheet:
    """A page while it is laid out: components get their numbers in the order of adding."""

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

    def label(
        self,
        name: str,
        place: tuple[int, int, int, int],
        text: str,
        font: int = 0,
        *,
        bco: int = GROUND,
    ) -> None:
        """Add a text that never changes; with a background of another colour it is centred."""
        own = {"pco": WHITE if font else DIM, "bco": bco, "xcen": int(bco != GROUND)}
        self.add("text", name, place, text_attributes(text, len(text), font) | own)

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
        own = {"pco": pco, "xcen": int(longest <= CENTRED)}
        self.add(
            "text", name, place, text_attributes("", longest, font) | own,
            release=release, shared=shared,
        )  # fmt: skip

    def number(
        self,
        name: str,
        place: tuple[int, int, int, int],
        font: int = LARGE,
        *,
        shared: bool = True,
        pco: int = WHITE,
    ) -> None:
        """Add a whole number that begins with 0."""
        attributes = {"val": 0, "font": font, "pco": pco, "bco": FIELD, "xcen": 1}
        self.add("number", name, place, attributes, shared=shared)

    def button(
        self, name: str, place: tuple[int, int, int, int], text: str, code: Code, bco: int = BUTTON
    ) -> None:
        """Add a button that does something when the finger leaves it."""
        own = {"bco": bco, "bco2": HELD, "pco2": WHITE} | BUTTON_STYLE
        attributes = text_attributes(text, max(len(text), 1), SMALL) | own
        self.add("button", name, place, attributes, release=code)

    def switch(  # noqa: PLR0913 - what differs between switches
        self,
        name: str,
        place: tuple[int, int, int, int],
        text: str,
        code: Code,
        *,
        longest: int,
        shared: bool = False,
    ) -> None:
        """Add a button of two states that begins in the first."""
        attributes = text_attributes(text, longest, SMALL)
        del attributes["bco"]  # a switch has a colour for each state
        own = {"val": 0, "bco0": BUTTON, "bco1": GREEN} | BUTTON_STYLE
        self.add("dual_state", name, place, attributes | own, release=code, shared=shared)

    def variable(self, name: str) -> None:
        """Add a hidden whole number."""
        self.add("variable", name, attributes={"sta": 0, "val": 0}, shared=True)

    def words(self, name: str, longest: int) -> None:
        """Add a hidden text."""
        self.add("variable", name, attributes={"sta": 1, "txt": "", "txt_maxl": longest})

    def page(self, *, preinitialize: Code = ()) -> Page:
        """Return the page; whenever the display shows it, the display reports its number."""
        shown = (f'print "#21 {self.id};"',)
        return Page(
            self.name, self.id, tuple(self.components), preinitialize, shown, meaning=self.meaning
        )


def text_attributes(text: str, longest: int, font: int) -> dict[str, Attribute]:
    """Return the attributes of a component that shows a text, white on the colour FIELD."""
    return {
        "txt": text, "txt_maxl": longest, "font": font, "pco": WHITE, "bco": FIELD,
        "xcen": 0, "ycen": 1,
    }  # fmt: skip
