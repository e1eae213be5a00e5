"""The indicators' C before the mutation engine: what LEDs show of a loop, and of its master."""

from functools import partial

import test_indicators as leds
from rig.firmware import Firmware, Program, on

CHECKS = {
    "loop": (leds.LOOP_LOW, leds.test_each_state_has_its_lights,
             leds.test_they_are_dark_from_the_reset_on_until_there_is_something_to_show,
             leds.test_blinking_is_half_a_second_each_way_to_the_tick),
    "master": (leds.HOSTED, leds.it_is_switched_by_its_master, leds.it_hears_its_master),
}  # fmt: skip
ARENAS = [
    Firmware(f"indicators/{name}", Program(text), ("indicators_block",),
             on(partial(leds.Shown, text), *checks))
    for name, (text, *checks) in CHECKS.items()
]  # fmt: skip
