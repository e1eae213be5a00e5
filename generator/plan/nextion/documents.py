"""The pages for those who build them in the Nextion editor: Markdown to read, JSON to compare."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from heatwright.generator.plan.parts import File
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.text import markdown
from heatwright.spec import Nextion
from heatwright.spec.nextion import FONTS, HEIGHT, WIDTH, Component, Page, display_pages

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
    context = {
        "title": markdown(identity.title or identity.name),
        "digest": source.spec.digest,
        "baud": interface.baud,
        "width": WIDTH,
        "height": HEIGHT,
        "fonts": [{"number": number, "height": height} for number, height in enumerate(FONTS)],
        "pages": [_page(page) for page in pages],
    }
    yield File("nextion/pages.md", "interfaces/nextion_pages.md.j2", context)
    lines = [json.dumps(_data(page), ensure_ascii=False) for page in pages]
    yield File(
        "nextion/pages.json",
        "interfaces/nextion_pages.json.j2",
        context | {"lines": ",\n".join(lines)},
    )


def _page(page: Page) -> dict[str, Any]:
    own = {"preinitialize": page.preinitialize, "postinitialize": page.postinitialize}
    return {
        "number": page.id,
        "name": page.name,
        "meaning": page.meaning,
        "bco": page.bco,
        "components": [_component(each) for each in page.components],
        "codes": [
            {"of": of, "event": EVENTS[event], "lines": lines}
            for of, events in (
                (f"page {page.name}", own),
                *((each.name, _events(each)) for each in page.components),
            )
            for event, lines in events.items()
            if lines
        ],
    }


def _component(component: Component) -> dict[str, Any]:
    return {
        "id": component.id,
        "name": component.name,
        "kind": KINDS[component.kind],
        "scope": "global" if component.shared else "local",
        "place": f"{component.x}, {component.y}, {component.w}, {component.h}"
        if component.w
        else "",
        "attributes": ", ".join(
            f"{name} {markdown(json.dumps(value, ensure_ascii=False))}"
            for name, value in component.attributes.items()
        ),
    }


def _events(component: Component) -> dict[str, tuple[str, ...]]:
    return {"press": component.press, "release": component.release, "timer": component.timer}


def _data(page: Page) -> dict[str, Any]:
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
                **{event: lines for event, lines in _events(each).items() if lines},
            }
            for each in page.components
        ],
    }
