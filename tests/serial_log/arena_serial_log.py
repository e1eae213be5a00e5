"""The log's C before the mutation engine: in RAM and in EEPROM."""

from collections.abc import Callable
from functools import partial

import test_serial_log as told
from rig.firmware import Firmware, on
from test_serial_log import LogBoard, program

TALK = ("log", "log_note", "log_talk", "log_port")


def arena(
    name: str, said: str, broken: tuple[str, ...], *checks: Callable[[LogBoard], None]
) -> Firmware:
    own = program(said)
    return Firmware(f"serial_log/{name}", own, broken, on(partial(LogBoard, own), *checks))


ARENAS = [
    arena("commands", told.SLOW_RAM, TALK, told.commands, told.empty),
    arena("images", told.HOURLY, (*TALK, "log_ring"), partial(told.images, count=10), told.busy),
    arena("ram", told.RAM, (*TALK, "log_ring"), partial(told.course, laps=12)),
    arena("slow line", told.SLOW_LINE, ("log_talk", "log_port", "log_ring"), told.slow),
]  # fmt: skip
