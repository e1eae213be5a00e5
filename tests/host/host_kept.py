"""Whether gains and a commanded setpoint outlive a loss of power as they should."""

from collections.abc import Iterator

from host_ring import BLANK
from host_storage import NEW_GAINS, OLD_GAINS, Storage

from heatwright.sim.host import Host

OFF_TICKS = 65
"""Enough to write any record, a byte a tick."""
REST_TICKS = 1100
"""More than the 10 s after which a setpoint is saved, and time to write it."""
NO_GAINS = (-1.0, -1e-30, 1.0001e6, float("inf"), float("nan"))
LEAST_GAINS = (0.0, 0.0, 0.0)
FAULT = 6


def kept_problem(host: Host) -> str:
    """Say the first thing that is wrong; empty if nothing, or if nothing is kept."""
    kept = Kept(host)
    for check in (kept.gains(), kept.bad_gains(), kept.setpoint()):
        for problem in check:
            return problem
    return ""


class Kept(Storage):
    """A host build of a commanded loop."""

    def gains(self) -> Iterator[str]:
        """Only what was kept comes back; a fault's record does not keep what was only set."""
        if not self.ring.keeps_gains:
            return
        library = self.host.library
        self.boot(bytes([BLANK]) * self.ring.bytes)
        self.set_gains(OLD_GAINS)
        library.settings_keep()
        library.settings_reload()
        yield from self._expect("kept and not yet written", OLD_GAINS)
        library.host_settle()
        self.boot()
        yield from self._expect("kept", OLD_GAINS)
        self.set_gains(NEW_GAINS)
        library.fault_trip(FAULT, 1.0)
        library.host_settle()
        yield from self._expect("only set, with a fault", NEW_GAINS)
        self.boot()
        yield from self._expect("a fault after they were only set", OLD_GAINS)
        library.settings_defaults()
        yield from self._expect("defaults", self.default.gains)
        library.host_settle()
        library.settings_reload()
        yield from self._expect("kept ones again", OLD_GAINS)
        library.settings_defaults()
        library.settings_keep()
        library.host_settle()
        self.boot()
        yield from self._expect("kept defaults", self.default.gains)
        yield from self._writes()

    def _writes(self) -> Iterator[str]:
        """What is kept already is not written again, and each gain that differs is."""
        for place in range(len(NEW_GAINS)):
            self.set_gains(OLD_GAINS)
            self._keep()
            if self._keep():
                yield "what is kept is written again"
            self.set_gains((*OLD_GAINS[:place], NEW_GAINS[place], *OLD_GAINS[place + 1 :]))
            if not self._keep():
                yield f"gain {place} is not written"

    def _keep(self) -> int:
        before = self.host.world.eeprom_writes
        self.host.library.settings_keep()
        self.host.library.host_settle()
        return int(self.host.world.eeprom_writes - before)

    def _expect(self, when: str, gains: tuple[float, ...]) -> Iterator[str]:
        if self.gains_now() != gains:
            yield f"{when}: the gains are {self.gains_now()}, not {gains}"

    def bad_gains(self) -> Iterator[str]:
        """What cannot be a gain is not taken, nor are the others beside it."""
        if not self.ring.keeps_gains:
            return
        records = [(gains, gains) for gains in (LEAST_GAINS, NEW_GAINS)]
        for place in range(3):
            for bad in NO_GAINS:
                gains = (*OLD_GAINS[:place], bad, *OLD_GAINS[place + 1 :])
                records.append((gains, self.default.gains))
        for stored, wanted in records:
            record = self.ring.record(1, self.old._replace(gains=stored))
            self.boot(self.ring.image({0: record}))
            yield from self._expect(f"{stored} in the record", wanted)

    def setpoint(self) -> Iterator[str]:
        """A loop that 0 switches off comes back with its setpoint if it held one; else off."""
        if not (self.ring.stores_setpoint and self._hosted):
            return
        library = self.host.library
        self.boot(bytes([BLANK]) * self.ring.bytes)
        library.loop_air_set(50.0)
        yield from self._expect_setpoint("set", 50.0)
        library.loop_air_set(0.0)
        yield from self._expect_setpoint("off", 0.0, OFF_TICKS)
        if self.host.build.parts.autotune:
            library.loop_air_tune(50.0, 5)
            yield from self._expect_setpoint("tuning", 0.0)
        if self.host.build.parts.tunable:
            library.loop_air_set(50.0)
            library.loop_air_set_manual(30.0)
            yield from self._expect_setpoint("by hand", 0.0)
        library.loop_air_set(50.0)
        library.fault_trip(FAULT, 1.0)
        library.fault_acknowledge()
        yield from self._expect_setpoint("acknowledged", 0.0)

    def _expect_setpoint(
        self, when: str, setpoint_c: float, ticks: int = REST_TICKS
    ) -> Iterator[str]:
        for _ in range(ticks):
            self.host.library.settings_tick()
        found = self.boot().setpoint_c
        if found != setpoint_c:
            yield f"{when}: the setpoint comes back as {found}, not {setpoint_c}"
