"""The menu's C, broken, and what then has to complain: walks through its screens."""

from pathlib import Path

from hosted_menu import BROKEN, SPEC, WORLD, problem_of, walks
from rig.firmware import headers_of, sources_of
from rig.hosted import InItsWorld


class Menu(InItsWorld):
    def headers(self) -> dict[str, str]:
        """Return the kiln's own, also of what is the world's."""
        return headers_of(sources_of(SPEC))


def problem(world: Path) -> str:
    return next(filter(None, (problem_of(world, walk) for walk in walks(77))), "")


ARENAS = [Menu("lcd_keypad/menu", lambda: WORLD, problem, broken="|".join(BROKEN))]
