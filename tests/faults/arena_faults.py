"""The chamber's guard and step, broken, in a program whose trips latch nothing."""

from collections.abc import Callable

from rig.firmware import Firmware, Program, changed
from test_self_checks import LATCHES, LATCHES_NOTHING, off_by_verdict

from heatwright.sim.binary.elf import Elf


class Unlatched(Program):
    """A firmware in which only the guard's verdict can switch the heater off."""

    def texts(self) -> dict[str, str]:
        """Return its files."""
        texts = super().texts()
        return texts | {"fault.c": changed(texts["fault.c"], (LATCHES, LATCHES_NOTHING))}


CHECKS: tuple[Callable[[Elf], object], ...] = (off_by_verdict,)
ARENAS = [Firmware("faults/verdict", Unlatched("chamber"), ("guard_air", "loop_air"), CHECKS)]
