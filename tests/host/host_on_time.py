"""Whether a loop's time on ends at its step, and nothing but off, a fault or a person renews it."""

from collections.abc import Iterator
from math import floor

from host_gate import COLD_C, Running

from heatwright.sim.host import Host

MEMORY_DAMAGED, ON_TOO_LONG = 29, 30
COUNT_BITS = 32


def on_time_problem(host: Host) -> str:
    """Say the first thing that is wrong; empty if nothing."""
    loop = host.build.controller.loops[host.build.parts.name]
    most_s = loop.protection.on_for_at_most_s
    if most_s is None:
        return ""
    return next(_Counted(host).problems(floor(1000 * most_s / round(1000 * loop.period_s))), "")


class _Counted(Running):
    """A loop that is on: what its steps count, by calls of what they call."""

    def problems(self, most: int) -> Iterator[str]:
        for seen in (0, 1):  # steps of the loop itself, before
            self._turn_on()
            for _ in range(seen):
                self.host.step()
            counted = self._steps()
            if not 0 < counted < most:
                yield f"on for {counted} steps"
            yield from self._ends(most - counted)
        yield from self._is_renewed(most)
        for bit in range(COUNT_BITS):
            yield from self._flipped(bit)

    def _turn_on(self) -> None:
        """Run it at its highest setpoint: a host has no other switch."""
        self.run_at(COLD_C)
        self.host.set_setpoint(self.loop.setpoint.maximum_c)
        self.host.step()

    def _ends(self, left: int) -> Iterator[str]:
        for number in range(left):
            if self.library.fault.code:
                yield f"fault {self.library.fault.code}, {left - number} steps too early"
            self._count(True)
        if self.library.fault.code != ON_TOO_LONG:
            yield f"fault {self.library.fault.code} after the time"
        self.library.host_acknowledge()
        if self.library.fault.code or self._steps() or not self._is_sound():
            yield f"acknowledged: {self._steps()} steps"

    def _is_renewed(self, most: int) -> Iterator[str]:
        self._turn_on()
        for _ in range(most - self._steps() - 1):
            self._count(True)
        self._count(False)
        if self.library.fault.code or self._steps() or not self._is_sound():
            yield f"off: fault {self.library.fault.code}, {self._steps()} steps"
        self._count(True)
        self.library.fault_trip(MEMORY_DAMAGED, 0.0)
        self._count(True)
        if self._steps() or not self._is_sound():
            yield f"at fault: {self._steps()} steps"

    def _flipped(self, bit: int) -> Iterator[str]:
        self._turn_on()
        if not self._is_sound():
            yield "the count is not sound from the start"
        guard = getattr(self.library, f"guard_{self.parts.name}")
        guard.on_steps ^= 1 << bit
        self.host.step()
        if self.library.fault.code != MEMORY_DAMAGED or self._steps() or not self._is_sound():
            yield f"bit {bit}: fault {self.library.fault.code}, {self._steps()} steps"

    def _steps(self) -> int:
        return int(getattr(self.library, f"guard_{self.parts.name}").on_steps)

    def _count(self, on: bool) -> None:
        getattr(self.library, f"guard_{self.parts.name}_count")(on)

    def _is_sound(self) -> bool:
        return bool(getattr(self.library, f"guard_{self.parts.name}_count_is_sound")())
