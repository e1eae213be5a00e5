"""The log's C before the mutation engine: in RAM and in EEPROM."""

from collections.abc import Callable
from functools import partial

from log_course import (
    EEPROM,
    OTHER_SPEC,
    RAM,
    SLOW_LINE,
    SLOW_RAM,
    busy_problem,
    commands_problem,
    course_problem,
    full,
    kept_problem,
    no_reading_problem,
    slow_problem,
)
from log_firmware import LogBoard, program
from rig.avr import Firmware, on

from heatwright.sim.elf import Elf

TALK = ("log", "log_note", "log_talk", "log_port")


class Logs(Firmware):
    """A log, in the one memory or the other."""

    def prepare(self) -> None:
        """Fill memories once for all trials."""
        super().prepare()
        if "log_ring_eeprom.h" in self.headers():
            full(EEPROM)
            full(OTHER_SPEC)


def arena(
    name: str,
    said: str,
    broken: tuple[str, ...],
    problems: tuple[Callable[[LogBoard], str], ...],
    *others: Callable[[Elf], str],
) -> Logs:
    """Say what complains of a board with this log."""
    checks = on(partial(LogBoard, program(said)), *problems) + others
    return Logs(f"serial_log/{name}", program(said), broken, checks)


short_course = partial(course_problem, laps=2)
ARENAS = [
    arena("ram", RAM, (*TALK, "log_ring"), (no_reading_problem, course_problem)),
    arena("commands", SLOW_RAM, TALK, (commands_problem,)),
    arena("slow line", SLOW_LINE, ("log_talk", "log_port", "log_ring"), (), slow_problem),
    arena("eeprom", EEPROM, ("log_ring",), (no_reading_problem, short_course), busy_problem,
          partial(kept_problem, each=3)),
]  # fmt: skip
