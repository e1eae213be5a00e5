"""The touch display's C, broken, and what then has to complain: the tests of the hosted kiln."""

from pathlib import Path

import test_touch_orders
import test_touch_shows
from hosted_kiln import WORLD
from rig.hosted import InItsWorld, first_complaint

JUDGES = (test_touch_shows, test_touch_orders)  # the quick ones first


def problem(built: Path) -> str:
    return first_complaint(JUDGES, hosted=built)


ARENAS = [InItsWorld("nextion/touched", lambda: WORLD, problem, broken=r"nextion|fault_log\.c")]
