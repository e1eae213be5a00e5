"""The pages for the person who makes them in the Nextion editor: Markdown, and JSON to compare."""

import json
from collections.abc import Iterable
from dataclasses import dataclass

from heatwright.generator.plan.interfaces.nextion.copies import (
    Making,
    Step,
    code,
    makings,
    values,
)
from heatwright.generator.plan.parts import File
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.text import markdown
from heatwright.spec import Nextion
from heatwright.spec.nextion import FONTS, HEIGHT, WIDTH, Page, display_pages

KINDS = {
    "text": "Text",
    "number": "Number",
    "button": "Button",
    "dual_state": "Dual-state Button",
    "waveform": "Waveform",
    "timer": "Timer",
    "variable": "Variable",
}
"""The components' names in the editor."""

EVENTS = {
    "press": "Touch Press Event",
    "release": "Touch Release Event",
    "timer": "Timer Event",
    "preinitialize": "Preinitialize Event",
    "postinitialize": "Postinitialize Event",
}


def documents(source: Source, interface: Nextion) -> Iterable[File]:
    """Plan nextion/pages.md and nextion/pages.json."""
    identity = source.controller.identity
    pages = display_pages(source.controller)
    made = makings(pages)
    context = PagesDocument(
        title=markdown(identity.title or identity.name),
        digest=source.spec.digest,
        baud=interface.baud,
        width=WIDTH,
        height=HEIGHT,
        fonts=list(enumerate(FONTS)),
        pages=[_page(making) for making in made],
        typed=sum(step.typed for making in made for step in making.steps),
        in_all=sum(_all(page) for page in pages),
        lines=",\n".join(json.dumps(_data(page), ensure_ascii=False) for page in pages),
    )
    yield File("nextion/pages.md", "interfaces/nextion/nextion_pages.md.j2", context)
    yield File("nextion/pages.json", "interfaces/nextion/nextion_pages.json.j2", context)


def _all(page: Page) -> int:
    """Count the values and events that would be typed without copies."""
    return sum(len(values(each)) + len(code(each, None)) for each in page.components)


@dataclass(frozen=True, slots=True)
class Code:
    """Lines to type at an event; of -- the component or page that has the event."""

    of: str
    event: str
    lines: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Made:
    """A component: how it is made, and the values to set."""

    id: int
    name: str
    made: str
    set: str


@dataclass(frozen=True, slots=True)
class Block:
    """A table of components, and the code to enter after it."""

    steps: list[Made]
    codes: list[Code]


@dataclass(frozen=True, slots=True)
class PageDocument:
    """A page, in the order in which it is made."""

    number: int
    name: str
    meaning: str
    bco: int
    of: str
    blocks: list[Block]
    codes: list[Code]


@dataclass(frozen=True, slots=True)
class PagesDocument:
    """The values for the templates of both documents."""

    title: str
    digest: str
    baud: int
    width: int
    height: int
    fonts: list[tuple[int, int]]
    """The number of each font in the editor, and its height in pixels."""
    pages: list[PageDocument]
    typed: int
    """Number of values and pieces of code that the person types; without copies it is `in_all`."""
    in_all: int
    lines: str
    """The pages as JSON, one a line."""


def _page(making: Making) -> PageDocument:
    page = making.page
    own = {"preinitialize": page.preinitialize, "postinitialize": page.postinitialize}
    return PageDocument(
        number=page.id,
        name=page.name,
        meaning=page.meaning,
        bco=page.bco,
        of=making.of.name if making.of else "",
        blocks=_blocks(making),
        codes=[
            Code(f"page {page.name}", EVENTS[event], lines) for event, lines in own.items() if lines
        ],
    )


def _blocks(making: Making) -> list[Block]:
    """Split the steps into tables; after each its code is entered, which later copies then have."""
    blocks: list[Block] = []
    for step in making.steps:
        if not blocks or blocks[-1].codes:
            blocks.append(Block([], []))
        blocks[-1].steps.append(_step(step, making.page))
        blocks[-1].codes.extend(
            Code(step.component.name, EVENTS[event], lines) for event, lines in step.code.items()
        )
    return blocks


def _step(step: Step, page: Page) -> Made:
    made = f"new {KINDS[step.component.kind]}"
    if step.of:
        other, old = step.of
        made = f"copy `{old.name}`" if other is page else f"copy `{other.name}.{old.name}`"
    values_set = "; ".join(
        f"{name} {markdown(json.dumps(value, ensure_ascii=False))}"
        for name, value in step.set.items()
        if name != "objname"
    )
    return Made(step.component.id, step.component.name, made, values_set)


def _data(page: Page) -> dict[str, object]:
    return {
        "id": page.id,
        "name": page.name,
        "bco": page.bco,
        "preinitialize": page.preinitialize,
        "postinitialize": page.postinitialize,
        "components": [
            {
                "id": each.id,
                "name": each.name,
                "kind": KINDS[each.kind],
                "scope": "global" if each.shared else "local",
                "place": [each.x, each.y, each.w, each.h],
                "attributes": dict(each.attributes),
                **code(each, None),
            }
            for each in page.components
        ],
    }
