"""Names in HAL of the controller and its loops, short enough for all suffixes."""

from heatwright.generator.plan.registers import BLOCK
from heatwright.spec import Controller

LONGEST_IN_HAL = 47
"""Maximum number of characters of a name in HAL (HAL_NAME_LEN of hal.h)."""
LONGEST_SUFFIX = max(len("--in.temperature.float"), len("--set-int.out-of-range"))
"""Length of the longest text behind the names of controller and loop, with both hyphens."""
LONGEST_LOOP = 12
LONGEST_CONTROLLER = LONGEST_IN_HAL - LONGEST_SUFFIX - LONGEST_LOOP


def controller_name(controller: Controller) -> str:
    """Prefix of all names of one controller; cut if it is too long."""
    return controller.identity.name[:LONGEST_CONTROLLER].rstrip("_")


def loop_names(controller: Controller) -> dict[str, str]:
    """Name in HAL of each loop by its name in the spec; a number if that is too long."""
    return {
        loop: loop if len(loop) <= LONGEST_LOOP else f"loop{number}"
        for number, loop in enumerate(controller.loops, start=1)
    }


def blocks(controller: Controller) -> dict[str, range]:
    """The addresses of each loop, the same in every table of the register map."""
    return {
        loop: range(BLOCK * number, BLOCK * (number + 1))
        for number, loop in enumerate(controller.loops, start=1)
    }
