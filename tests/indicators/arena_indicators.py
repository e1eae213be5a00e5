"""The indicators' C before the mutation engine: what LEDs show of a loop, and of its master."""

import test_indicators
import test_indicators_master as master
from indicated_board import LEDS, MASTER, Shown, text_of
from rig.avr import Firmware, Program

from heatwright.sim.elf import Elf


class Lights(Firmware):
    """An oven with LEDs."""


def states(elf: Elf) -> None:
    """Go through every state of the loop."""
    test_indicators.test_each_state_has_its_lights(Shown(elf=elf))


def blinking(elf: Elf) -> None:
    """Time a blink."""
    test_indicators.test_blinking_is_half_a_second_each_way_to_the_tick(Shown(elf=elf))


def heard(elf: Elf) -> str:
    """Let a master come and go."""
    found = master.course(master.alone(MASTER, elf))
    return "" if found == master.HEARD else f"{found}"


ARENAS = [
    Lights(f"indicators/{name}", Program(text_of(interfaces)), ("indicators_block",), checks)
    for name, interfaces, checks in (
        ("loop", LEDS, (states, blinking)),
        ("master", MASTER, (heard,)),
    )
]
