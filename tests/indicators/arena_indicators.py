"""The indicators' C before the mutation engine: what LEDs show of a loop, and of its master."""

import test_indicators as shown
from indicated_board import LEDS, MASTER, Shown, text_of
from rig.avr import Firmware, Program, on

from heatwright.sim.elf import Elf


class Lights(Firmware):
    """An oven with LEDs."""


def heard(elf: Elf) -> str:
    """Let a master come and go."""
    found = shown.course(shown.alone(MASTER, elf))
    return "" if found == shown.HEARD else f"{found}"


LOOP = on(
    lambda elf: Shown(elf=elf),
    shown.test_each_state_has_its_lights,
    shown.test_blinking_is_half_a_second_each_way_to_the_tick,
)
ARENAS = [
    Lights(f"indicators/{name}", Program(text_of(interfaces)), ("indicators_block",), checks)
    for name, interfaces, checks in (("loop", LEDS, LOOP), ("master", MASTER, (heard,)))
]
