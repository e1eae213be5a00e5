"""The C of analog sensors before the mutation engine: the ADC's scan, codes, and their meaning."""

from functools import partial

import test_adc as adc
from rig.firmware import Firmware, Program, on
from rig.sensors import bed, powered, sensor

from heatwright.sim.device import AvrDevice
from heatwright.spec.sensing.conversion import conversion

HOTEND = bed("hotend")


def edges(plate: AvrDevice) -> None:
    """Hold all codes next to a limit or a point of the table."""
    table = conversion(sensor("hotend"), "atmega328p")
    low, high, low_limit, high_limit, _ = table.limits
    places = [low, (low + low_limit) / 2, high, (high + high_limit) / 2]
    places += [point.raw / adc.OVERSAMPLE for point in table.points]
    near = {int(each) + off for each in places for off in (-1, 0, 1)}
    adc.every_code(plate, sorted(near | {0, 1, 1022, 1023}))


CHECKS = on(
    partial(powered, HOTEND),
    adc.test_its_clock_gives_all_ten_bits_of_the_supply_and_no_input_is_digital,
    adc.test_one_scan_may_be_lost, adc.test_a_scan_that_does_not_end_leaves_no_old_reading,
    partial(adc.test_one_bad_code_spoils_the_reading, code=1023, status=adc.OPEN),
    adc.test_it_is_of_the_last_codes_before_the_step, edges,
)  # fmt: skip
ARENAS = [Firmware("analog/hotend", Program(HOTEND), ("adc", "sensor_bed", "celsius_bed"), CHECKS)]
