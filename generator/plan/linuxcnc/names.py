"""Names in HAL: of the controller and its loops, short enough for what is hung on them."""

from __future__ import annotations

from heatwright.generator.plan.registers import BLOCK
from heatwright.spec import Controller

LONGEST_IN_HAL = 47
"""Characters of a name in HAL (HAL_NAME_LEN of hal.h)."""
LONGEST_SUFFIX = max(len("--in.temperature.float"), len("--set-int.out-of-range"))
"""What is hung on the two names at most."""
LONGEST_LOOP = 12
LONGEST_CONTROLLER = LONGEST_IN_HAL - LONGEST_SUFFIX - LONGEST_LOOP


def controller_name(controller: Controller) -> str:
    """Begin of all names of one controller; what is too long is cut."""
    return controller.identity.name[:LONGEST_CONTROLLER].rstrip("_")


def loop_names(controller: Controller) -> dict[str, str]:
    """Name in HAL of each loop by its name in the spec; for what is too long, a number."""
    return {
        loop: loop if len(loop) <= LONGEST_LOOP else f"loop{number}"
        for number, loop in enumerate(controller.loops, start=1)
    }


def blocks(controller: Controller) -> dict[str, range]:
    """Addresses of each loop in every table of the register map."""
    return {
        loop: range(BLOCK * number, BLOCK * (number + 1))
        for number, loop in enumerate(controller.loops, start=1)
    }
