"""The log's C before the mutation engine: in RAM and in EEPROM."""

from collections.abc import Callable
from functools import partial

import test_serial_log as told
from rig.avr import Firmware, on
from test_serial_log import LogBoard, program

TALK = ("log", "log_note", "log_talk", "log_port")


class Logs(Firmware):
    """A log, in the one memory or the other."""

    def prepare(self) -> None:
        """Fill memories once for all trials."""
        super().prepare()
        if "log_ring_eeprom.h" in self.headers():
            told.full(told.EEPROM)
            told.full(told.OTHER_SPEC)


def arena(
    name: str, said: str, broken: tuple[str, ...], *checks: Callable[[LogBoard], None]
) -> Logs:
    """Say what complains of a board with this log."""
    own = program(said)
    return Logs(f"serial_log/{name}", own, broken, on(partial(LogBoard, own), *checks))


ARENAS = [
    arena("ram", told.RAM, (*TALK, "log_ring"), told.no_reading, partial(told.course, laps=12)),
    arena("commands", told.SLOW_RAM, TALK, told.commands),
    arena("slow line", told.SLOW_LINE, ("log_talk", "log_port", "log_ring"), told.slow),
    arena("eeprom", told.EEPROM, ("log_ring",), told.no_reading, partial(told.course, laps=2),
          told.busy, partial(told.kept, each=3)),
]  # fmt: skip
