"""The touch display's C, broken, and what then has to complain: the tests of the hosted kiln."""

from collections.abc import Mapping
from pathlib import Path
from shutil import copy

import test_touch_hostile
import test_touch_orders
import test_touch_points
import test_touch_shows
from hosted_kiln import FILES, WORLD
from rig.judged import first_complaint

JUDGES = (test_touch_orders, test_touch_points, test_touch_shows, test_touch_hostile)
"""The quick ones first."""


class HostedKiln:
    """The kiln that `hosted_kiln` describes, as a library that each play forks anew."""

    name = "nextion/touched"
    together = True

    def sources(self) -> Mapping[str, str]:
        """Return what the display is made of."""
        display = {name for name in FILES if name.startswith("nextion")} | {"fault_log.c"}
        return {name: WORLD.sources[name] for name in sorted(display)}

    def build(self, changed: Mapping[str, str], folder: Path) -> Path:
        """Compile with these texts."""
        return Path(copy(WORLD.library(changed), folder / "hosted.so"))

    def prepare(self) -> None:
        """Nothing is shared by the trials."""

    def problem(self, built: Path) -> str:
        """Give all orders, look at all that is shown, send noise."""
        return first_complaint(JUDGES, hosted=built)


ARENAS = [HostedKiln()]
