"""Whether what switches a loop off does so at once, and heater and cooler are never on together."""

from collections.abc import Callable, Iterator

from host_gate import COLD_C, HOT_C, LONG, TARGET_C, Running

from heatwright.sim.host import Host
from heatwright.sim.reference.programs.state import RUNNING

FAULT = 6
WAYS, ONE = 1, 2
"""Programs that heat, the second with one segment."""
NEAR_C = 44.5
"""Where that has just reached its target, within its first 2 s."""
MOST_STEPS = 20
START_C = 30.0


def switching_problem(host: Host) -> str:
    """Say the first thing that is wrong; empty if nothing."""
    parts, switching = host.build.parts, _Switching(host)
    checks = [switching.apart(), switching.hanging()] if parts.cooler else []
    if parts.programmed:
        checks += [switching.ordered_off(), switching.finished()]
    elif parts.switched:
        checks.append(switching.switched_off())
    elif parts.commanded:
        checks.append(switching.off_by_its_step())
    found = next((problem for check in checks for problem in check), "")
    host.world.main_hangs = host.world.loop_hangs = 0
    return found


class _Switching(Running):
    def switched_off(self) -> Iterator[str]:
        """What switches off does so before the step that takes it over."""
        events: dict[str, Callable[[], object]] = {"off": self.library.loop_air_disable}
        events["acknowledged"] = self._trip_and_acknowledge
        events["off and on"] = self._off_and_on
        if self.parts.autotune:
            events["tuning stopped"] = self._tune_and_stop
        for name, event in events.items():
            self.run_at(COLD_C)
            if not self.ticks(1)[0]:
                yield f"{name}: it did not heat before"
            event()
            heated, _ = self.ticks(self.period_ticks - 2)
            if heated:
                yield f"{name}: it heats for {heated} more ticks"
        for name, event in (("a lost reading", self._lose), ("a fault", self._trip)):
            self.run_at(COLD_C)
            event()
            self.host.step()
            if self.ticks(self.period_ticks - 1)[0]:
                yield f"{name}: it is held on"

    def off_by_its_step(self) -> Iterator[str]:
        """A heater that stays on for a while is off when its loop is."""
        self.run_at(COLD_C)
        if not self.ticks(1)[0]:
            yield "it did not heat before"
        self.host.set_setpoint(0.0)
        self.host.step()
        if self.ticks(1)[0]:
            yield "off, and it is held on"

    def _trip(self) -> None:
        self.library.fault_trip(FAULT, COLD_C)

    def _lose(self) -> None:
        self.host.set_reading(4, 0)

    def _trip_and_acknowledge(self) -> None:
        self._trip()
        self.library.host_acknowledge()

    def _off_and_on(self) -> None:
        self.library.loop_air_disable()
        if not self.library.loop_air_enable():
            message = "It cannot be switched on again"
            raise AssertionError(message)

    def _tune_and_stop(self) -> None:
        self.library.loop_air_tune(TARGET_C, 5)
        self.library.loop_air_stop_tuning()

    def ordered_off(self) -> Iterator[str]:
        """Stop, pause and off do not wait for the step that takes them over."""
        events: dict[str, Callable[[], object]] = {
            "stop": self.library.program_stop,
            "pause": self.library.program_pause,
            "off": self.library.loop_air_disable,
        }
        for name, event in events.items():
            self._start_at(START_C, WAYS)
            self.host.set_reading(0, self.scale.code(START_C - 2.5))
            for _ in range(4):
                self.host.step()
            if self.library.program.state != RUNNING or not self.ticks(2)[0]:
                yield f"{name}: it did not heat before"
            event()
            heated, _ = self.ticks(self.period_ticks - 3)
            if heated:
                yield f"{name}: it heats for {heated} more ticks"
            self.host.step()
            for _ in range(3):
                self.ticks(self.period_ticks - 1)
                if self.ticks(1)[0] or self.library.loop_air.enabled:
                    yield f"{name}: it goes on heating"

    def finished(self) -> Iterator[str]:
        """A heater that may have to stay on for a while is off when its program has ended."""
        assert self.host.build.controller.programs is not None
        if self.host.build.controller.programs.at_end == "hold":
            return
        self._start_at(NEAR_C, ONE)
        heated = 0
        for _ in range(MOST_STEPS):
            self.host.step()
            if self.library.program.ended:
                break
            heated = self.ticks(1)[0]
        if not heated or self.ticks(self.period_ticks - 1)[0]:
            yield f"finished after {heated} ticks of heat, and it is held on"

    def _start_at(self, celsius: float, program: int) -> None:
        self.run_at(celsius)
        self.library.loop_air_disable()
        self.host.step()
        self.library.program_start(program)

    def apart(self) -> Iterator[str]:
        """Whichever is on keeps the other off, whatever is asked of both."""
        for first, reading_c in (("heater", COLD_C), ("cooler", HOT_C)):
            self.run_at(reading_c)
            self.host.world.loop_hangs = 1
            self.library.output_heater_set(100.0)
            self.library.output_cooler_set(100.0)
            heated, cooled = self.ticks(self.period_ticks)
            wanted = (first == "heater", first == "cooler")
            if (heated > 0, cooled > 0) != wanted:
                yield f"{first} was on, then both: heater {heated}, cooler {cooled} ticks"
            if self.host.world.both_on:
                yield f"{first} was on, then both: they are on together"

    def hanging(self) -> Iterator[str]:
        """A main loop that stands still leaves the cooler as it is, and lets nothing heat."""
        self.run_at(HOT_C)
        self.host.world.main_hangs = 1
        if (found := self.ticks(LONG)) != (0, LONG):
            yield f"cooling and hanging: heater {found[0]}, cooler {found[1]} of {LONG} ticks"
        self.run_at(COLD_C)
        self.host.world.main_hangs = 1
        self.library.output_cooler_set(100.0)
        self.ticks(LONG)
        heated, cooled = self.ticks(LONG)
        if heated or cooled != LONG:
            yield "heating and hanging: the cooler does not follow the heater"
