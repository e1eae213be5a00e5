"""The C of a current's sensor before the mutation engine: its codes, and the amperes they mean."""

from collections.abc import Callable
from functools import partial

import test_current_firmware as current
from current_board import Measured, text_of
from rig.avr import Firmware, Program

from heatwright.sim.elf import Elf


class Currents(Firmware):
    """A heater whose current is measured."""


def check(test: Callable[[Measured], None], elf: Elf) -> None:
    """Run a test on the binary."""
    test(Measured("hall", elf))


ARENAS = [
    Currents(
        "current/hall",
        Program(text_of("hall")),
        ("sensor_amps", "amperes_amps"),
        tuple(
            partial(check, test)
            for test in (
                current.it_reads_what_flows,
                current.test_a_reading_is_of_the_last_moments_before_the_step,
                current.test_a_current_below_the_scale_is_none,
                current.test_an_adc_that_hangs_leaves_the_last_current,
            )
        ),
    )
]
