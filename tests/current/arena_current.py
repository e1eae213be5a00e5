"""The C of a current's sensor before the mutation engine: its codes, and the amperes they mean."""

from functools import partial

import test_current_firmware as current
from rig.firmware import Firmware, Program, on

HALL = on(
    partial(current.Measured, "hall"),
    current.it_reads_what_flows,
    current.test_a_reading_is_of_the_last_moments_before_the_step,
    current.test_a_current_below_the_scale_is_none,
    current.test_an_adc_that_hangs_leaves_the_last_current,
)
ARENAS = [
    Firmware(
        "current/hall", Program(current.text_of("hall")), ("sensor_amps", "amperes_amps"), HALL
    )
]
