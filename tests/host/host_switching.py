"""Whether a switched loop switches at once, and refuses what it says it would."""

from collections.abc import Callable, Iterator
from random import Random

from host_cooling import Cooling
from host_running import COLD_C, MOST_C, TARGET_C, Running

from heatwright.sim.host import Host

FAULT = 6
RANDOM_ORDERS = 3000
REST_TICKS = 1100
"""More than the 10 s after which a setpoint is saved, and time to write it."""


def switching_problem(host: Host) -> str:
    """Say the first thing that is wrong; empty if nothing."""
    parts = host.build.parts
    switching = _Switching(host)
    cooling = Cooling(host)
    checks = [cooling.apart(), cooling.hanging()] if parts.cooler else []
    if parts.switched:
        checks += [switching.at_once(), switching.told(), switching.held(), switching.kept()]
        checks.append(switching.after_power_up())
    elif parts.commanded:
        checks.append(switching.off_by_its_step())
    found = next((problem for check in checks for problem in check), "")
    host.world.main_hangs = host.world.loop_hangs = 0
    return found


class _Switching(Running):
    def at_once(self) -> Iterator[str]:
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
        self.library.fault_acknowledge()

    def _off_and_on(self) -> None:
        self.library.loop_air_disable()
        if not self.library.loop_air_enable():
            message = "It cannot be switched on again"
            raise AssertionError(message)

    def _tune_and_stop(self) -> None:
        self.library.loop_air_tune(TARGET_C, 5)
        self.library.loop_air_stop_tuning()

    def _tune_to_the_end(self) -> None:
        """It waits for the machine to cool down until its time is over."""
        self.library.loop_air_tune(COLD_C + 1, 5)
        assert self.loop.autotune is not None
        for _ in range(round(self.loop.autotune.timeout_s / self.loop.period_s) + 1):
            self.host.step()

    def told(self) -> Iterator[str]:
        """Who asks whether a command may be given is told what giving it says."""
        random = Random("switching")  # noqa: S311
        self.run_at(COLD_C)
        for _ in range(RANDOM_ORDERS):
            self._do_something(random)
            yield from self._compare("enable", self.library.loop_air_is_enabled)
            setpoint_c = random.choice((-0.5, 0.0, 30.0, TARGET_C, MOST_C, 250.5, float("nan")))
            wanted = 0 <= setpoint_c <= MOST_C and not self._tunes_for_other_than(setpoint_c)
            if self.library.loop_air_may_set(setpoint_c) != wanted:
                yield f"may set {setpoint_c}: not {wanted}"
            yield from self._compare("set", self._setpoint, setpoint_c)
            if self.parts.tunable:
                yield from self._by_hand(random)

    def _tunes_for_other_than(self, setpoint_c: float) -> bool:
        if not self.parts.autotune or self.library.loop_air_mode() != self.library.MODE_TUNING:
            return False
        return setpoint_c != self._setpoint()

    def _do_something(self, random: Random) -> None:
        library = self.library
        events: list[Callable[[], object]] = [
            library.loop_air_disable, self._trip, library.fault_acknowledge, self.host.step,
            lambda: None, library.loop_air_disable,
        ]  # fmt: skip
        if self.parts.autotune:
            tune = [lambda: library.loop_air_tune(TARGET_C, 3)] * 4
            events += [*tune, library.loop_air_stop_tuning]
        random.choice(events)()

    def _compare(self, what: str, value: Callable[[], object], *arguments: float) -> Iterator[str]:
        may = getattr(self.library, f"loop_air_may_{what}")(*arguments)
        before = value()
        done = getattr(self.library, f"loop_air_{what}")(*arguments)
        if may != done:
            yield f"{what}{arguments}: it may {may}, and does {done}"
        wanted = (arguments[0] if arguments else True) if done else before
        if value() != wanted:
            yield f"{what}{arguments}: {value()} instead of {wanted}"

    def _setpoint(self) -> float:
        return float(self.library.settings.air_setpoint_c)

    def _by_hand(self, random: Random) -> Iterator[str]:
        library = self.library
        before = library.loop_air_mode()
        library.loop_air_set_automatic()
        left = library.MODE_AUTOMATIC if before == library.MODE_MANUAL else before
        if library.loop_air_mode() != left:
            yield f"automatic, from mode {before}: {library.loop_air_mode()}"
        if random.random() < 0.5:
            yield from self._taken_in_hand(random)

    def _taken_in_hand(self, random: Random) -> Iterator[str]:
        library = self.library
        percent = random.choice((-0.5, 0.0, 12.5, 100.0, 100.5, float("nan")))
        before = library.loop_air_manual_percent(), library.loop_air_mode()
        done = library.loop_air_set_manual_percent(percent)
        if done != (0 <= percent <= 100):
            yield f"{percent} % by hand: {done}"
        if (library.loop_air_manual_percent(), library.loop_air_mode()) != (
            percent if done else before[0],
            before[1],
        ):
            yield f"{percent} % by hand changes the mode, or not the duty"
        taken = library.loop_air_set_manual(25.0)
        may = library.loop_air_is_enabled() and not library.fault.code
        if taken != may or (taken and library.loop_air_mode() != library.MODE_MANUAL):
            yield f"by hand: {taken}, and it may {may}"

    def held(self) -> Iterator[str]:
        """A master that says "on" all the time restarts nothing."""
        ends: dict[str, Callable[[], object]] = {"acknowledged": self._trip_and_acknowledge}
        if self.parts.autotune:
            ends |= {"tuning stopped": self._tune_and_stop, "tuning ended": self._tune_to_the_end}
        for name, end in ends.items():
            self.run_at(COLD_C)
            end()
            for _ in range(5):
                if self.library.loop_air_enable():
                    yield f"{name}: on, without an off before"
                self.host.step()
            self.library.loop_air_disable()
            if not self.library.loop_air_enable():
                yield f"{name}: off, but not on again"
        self.run_at(COLD_C)
        self._trip()
        self.library.loop_air_disable()
        if self.library.loop_air_enable():
            yield "on, with a fault latched"
        self.library.fault_acknowledge()
        if not self.library.loop_air_enable():
            yield "off while the fault was latched does not count"

    def after_power_up(self) -> Iterator[str]:
        self.host.erase()
        self.host.power_up()
        starts = self.loop.starts != "disabled"
        if self.library.loop_air_is_enabled() != starts:
            yield f"after a reset it is not {self.loop.starts}"
        if self.library.loop_air_enable() != starts:
            yield "after a reset it is switched on without an off before"

    def kept(self) -> Iterator[str]:
        """A setpoint is stored when it has rested, and not for being said again."""
        if not self.loop.setpoint.stored:
            return
        self.host.erase()
        self.host.power_up()
        for setpoint_c, wanted_c in ((TARGET_C, TARGET_C), (0.0, 0.0)):
            self.library.loop_air_set(setpoint_c)
            self.library.loop_air_disable()
            yield from self._expect_kept(wanted_c)
        writes = self.host.world.eeprom_writes
        for _ in range(3):
            self.library.loop_air_set(0.0)
            self._rest()
        if self.host.world.eeprom_writes != writes:
            yield "the same setpoint wears the EEPROM out"

    def _expect_kept(self, wanted_c: float) -> Iterator[str]:
        self._rest()
        self.host.power_up()
        if self._setpoint() != wanted_c:
            yield f"the setpoint comes back as {self._setpoint()}, not {wanted_c}"

    def _rest(self) -> None:
        for _ in range(REST_TICKS):
            self.library.settings_tick()
