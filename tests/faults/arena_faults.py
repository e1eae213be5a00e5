"""The chamber's guard and step, broken, where trips latch nothing; and a kiln's program."""

from collections.abc import Callable
from dataclasses import replace

from fault_machines import site_of
from rig.firmware import Firmware, Program, changed
from test_self_checks import LATCHES, LATCHES_NOTHING, off_by_verdict
from test_upsets import BEGINS, moves_no_firing

from heatwright.sim.binary.elf import Elf


class Unlatched(Program):
    """A firmware in which only the guard's verdict can switch the heater off."""

    def texts(self) -> dict[str, str]:
        texts = super().texts()
        return texts | {"fault.c": changed(texts["fault.c"], (LATCHES, LATCHES_NOTHING))}


BITS = 8


def no_firing_is_moved(program: Elf) -> None:
    """Judge a kiln: no flipped bit of its program moves a firing."""
    for begin in BEGINS:
        moves_no_firing(replace(site_of("kiln"), program=program), begin, BITS)


CHECKS: tuple[Callable[[Elf], object], ...] = (off_by_verdict,)
ARENAS = [
    Firmware("faults/verdict", Unlatched("chamber"), ("guard_air", "loop_air"), CHECKS),
    Firmware("faults/program", Program("kiln"), ("program",), (no_firing_is_moved,)),
]
