"""Finds the values to type into the editor: the differences from an earlier component or page.

The editor cannot import text, but copies components and pages with their contents. So a component
or page is made from a copy of a similar earlier one, and only the differences are typed.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from heatwright.spec.nextion import Component, Page

EVENTS = ("press", "release", "timer")
Value = int | str


@dataclass(frozen=True, slots=True)
class Step:
    """How one component is made.

    of -- the component to copy, with its page; None: a new component, or one of a copied page;
    set -- values to type; code -- events whose code is replaced, or deleted if there are no lines.
    """

    component: Component
    of: tuple[Page, Component] | None
    set: Mapping[str, Value]
    code: Mapping[str, tuple[str, ...]]

    @property
    def typed(self) -> int:
        """Number of values and events that are typed."""
        return len(self.set) + len(self.code)


@dataclass(frozen=True, slots=True)
class Making:
    """How a page is made. of -- the page to copy; steps -- components to add or to change."""

    page: Page
    of: Page | None
    steps: tuple[Step, ...]


def makings(pages: Iterable[Page]) -> list[Making]:
    """Find how each page is made with the least typing."""
    found: list[Making] = []
    for page in pages:
        earlier = [each.page for each in found]
        like = next((each for each in earlier if _shape(each) == _shape(page)), None)
        found.append(_copied(page, like) if like else _built(page, earlier))
    return found


def values(component: Component) -> dict[str, Value]:
    """List the attributes of a component as the editor's table shows them, without its number."""
    placed = {"x": component.x, "y": component.y, "w": component.w, "h": component.h}
    scope = "global" if component.shared else "local"
    return {
        "objname": component.name,
        "vscope": scope,
        **(placed if component.w else {}),
        **component.attributes,
    }


def _shape(page: Page) -> list[tuple[str, str]]:
    return [(each.kind, each.name) for each in page.components]


def _copied(page: Page, like: Page) -> Making:
    """Return the changes to a copied page, whose components keep their places."""
    steps = (
        Step(new, None, _differs(new, old), code(new, old))
        for new, old in zip(page.components, like.components, strict=True)
    )
    return Making(page, like, tuple(each for each in steps if each.typed))


def _built(page: Page, earlier: list[Page]) -> Making:
    steps: list[Step] = []
    for new in page.components:
        others = [(page, each.component) for each in steps]
        others += [(other, each) for other in earlier for each in other.components]
        able = [(other, old) for other, old in others if _can_be(new, old)]
        ways = [Step(new, None, values(new), code(new, None))]
        ways += [Step(new, of, _differs(new, of[1], moved=True), code(new, of[1])) for of in able]
        steps.append(min(ways, key=lambda way: way.typed))
    return Making(page, None, tuple(steps))


def _can_be(new: Component, old: Component) -> bool:
    """Return whether `new` can be a copy of `old`: same kind, same attributes."""
    return old.kind == new.kind and values(old).keys() == values(new).keys()


def _differs(new: Component, old: Component, *, moved: bool = False) -> dict[str, Value]:
    """List the values that differ. moved -- the editor gives the copy another place and name."""
    had = values(old)
    again = {"objname", "x", "y"} if moved else set()
    return {
        name: value for name, value in values(new).items() if name in again or had[name] != value
    }


def code(new: Component, old: Component | None) -> dict[str, tuple[str, ...]]:
    """Return the lines of code that differ from those of `old` (None: no code), by event."""
    found = {event: getattr(new, event) for event in EVENTS}
    had = {event: getattr(old, event) if old else () for event in EVENTS}
    return {event: lines for event, lines in found.items() if lines != had[event]}
