"""The touch display's C, broken, and what then has to complain: the tests of the hosted kiln."""

import test_touch_orders
import test_touch_shows
from hosted_kiln import WORLD
from rig.hosted import InItsWorld, first_complaint

JUDGES = (test_touch_shows, test_touch_orders)
"""The quick ones first."""


class Touched(InItsWorld):
    """Of the kiln's files those of which the display is made."""

    def headers(self) -> dict[str, str]:
        """Return what the files include."""
        return {name: text for name, text in WORLD.sources.items() if name.endswith(".h")}

    def sources(self) -> dict[str, str]:
        """Return the files that may be broken."""
        found = super().sources()
        mine = (name for name in found if name.startswith("nextion") or name == "fault_log.c")
        return {name: found[name] for name in mine}


ARENAS = [
    Touched("nextion/touched", lambda: WORLD, lambda built: first_complaint(JUDGES, hosted=built))
]
