"""The menu's C, broken, and what then has to complain: walks through its screens."""

from pathlib import Path

from hosted_menu import BROKEN, SPEC, WORLD, problem_of, walks
from rig.firmware import sources_of
from rig.hosted import InItsWorld


class Menu(InItsWorld):
    """Of the kiln's files those of which the menu is made."""

    def sources(self) -> dict[str, str]:
        """Return the files that may be broken."""
        return {name: text for name, text in super().sources().items() if name in BROKEN}

    def headers(self) -> dict[str, str]:
        """Return what the files include."""
        return {name: text for name, text in sources_of(SPEC).items() if name.endswith(".h")}


def problem(world: Path) -> str:
    """Walk until something is not as the model has it."""
    return next(filter(None, (problem_of(world, walk) for walk in walks(77))), "")


ARENAS = [Menu("menu/walks", lambda: WORLD, problem)]
