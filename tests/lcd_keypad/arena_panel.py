"""The chamber's panel, broken, and what then has to complain: the tests of its keys and lines."""

from collections.abc import Callable
from functools import partial

import test_panel
import test_start
from rig.firmware import Firmware, Program
from rig.hosted import first_complaint

from heatwright.sim.binary.elf import Elf


def problem(program: Elf) -> str:
    test_start.program = lambda: program
    return first_complaint([test_panel, test_start])


def timed(name: str, spec: str, *tests: Callable[[], object]) -> Firmware:
    def judge(program: Elf) -> str:
        test_panel.whole = lambda _: program
        for test in tests:
            test()
        return ""

    broken = (*("countdown",) * ("countdown:" in spec), "panel")
    return Firmware(f"lcd_keypad/panel {name}", Program(spec), broken, (judge,))


MEMBERS = ("minutes", "counting", "left", "check")
ARENAS = [
    Firmware("lcd_keypad/panel chamber", Program("chamber"), ("panel",), (problem,)),
    timed(
        "long",
        test_panel.LONG,
        *(
            partial(test_panel.test_a_bit_that_flips_ends_the_time_at_once, each)
            for each in MEMBERS
        ),
        test_panel.test_a_time_waits_for_the_setpoint,
        test_panel.test_a_key_held_down_changes_the_time_and_no_setpoint,
    ),
    timed("slow", test_panel.SLOW, test_panel.test_a_time_below_a_step_is_over_with_it),
    *(
        timed(
            name,
            test_panel.OTHERS[name],
            partial(test_panel.test_any_keys_do_what_the_model_does, name),
        )
        for name in ("a time", "a master's time", "a time and a number")
    ),
    timed(
        "numbers",
        test_panel.OTHERS["numbers"],
        test_panel.test_a_number_is_kept_when_it_has_rested,
        partial(test_panel.test_a_number_that_no_key_sets_is_the_specs, -1e-3),
        partial(test_panel.test_any_keys_do_what_the_model_does, "numbers"),
    ),
]
