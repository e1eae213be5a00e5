"""Whether the gate lets a heater on only while every permit is fresh, and off at once: to the tick.
The permits, from the design: the main loop may be silent for 100 ms, the control step for two
periods, the sensor for `stale_after`; a fault or a fan that stands still act at once. A loop's time
on ends at its step, and nothing but off, a fault or a person renews it. What switches a loop off
does so at once."""

from collections.abc import Callable, Iterator
from math import floor

from host_values import scale_of

from heatwright.sim.host import Command, Host
from heatwright.sim.reference.programs.state import RUNNING

HOT_C, COLD_C, TARGET_C = 240.0, 60.0, 150.0
LONG = 3000  # ticks in which every permit runs out
MAIN_TICKS = 10
BEYOND_TICKS = 60  # watched after every permit has run out
WELL_TICKS = 15  # more than the main loop may be silent for, and too few for any rule to trip
NO_SENSOR = 1


class Running:
    def __init__(self, host: Host) -> None:
        self.host = host
        self.library = host.library
        self.parts = host.build.parts
        self.scale = scale_of(host.build.controller)
        self.loop = host.build.controller.loops[self.parts.name]
        self.period_ticks = round(self.loop.period_s * 100)
        output = host.build.controller.outputs[self.parts.heater]
        self.window_ticks = round(100 * getattr(output, "window_s", 0))

    def run_at(self, celsius: float) -> None:
        host = self.host
        host.world.main_hangs = host.world.loop_hangs = host.world.fan_stands_still = 0
        host.renew()
        host.set_reading(0, self.scale.code(celsius))
        host.set_setpoint(TARGET_C)
        host.step()
        if self.parts.switched:
            for command in (Command.DISABLE, Command.ENABLE):
                host.command(command)
                host.step()
        for _ in range(3):
            host.step()

    def ticks(self, ticks: int) -> tuple[int, int]:
        world = self.host.world
        before = world.heater_counts, world.cooler_ticks
        for _ in range(ticks):
            self.library.host_tick()
        return int(world.heater_counts - before[0]), int(world.cooler_ticks - before[1])

    def full(self, ticks: int, renew: str = "") -> int:
        """Return in how many of the next ticks it heats, with full power asked for."""
        put = getattr(self.library, f"output_{self.parts.heater}_set")
        on = 0
        for _ in range(ticks):
            put(100.0)
            before = self.host.world.heater_counts
            self.library.host_tick()
            on += self.host.world.heater_counts != before
            if renew:
                getattr(self.library, renew)()
        return on


def gate_problem(host: Host) -> str:
    gate = _Gate(host)
    found = next(gate.problems(), "")
    host.world.main_hangs = host.world.loop_hangs = host.world.fan_stands_still = 0
    return found


class _Gate(Running):
    """A loop whose output is asked for full power at every tick, whatever its algorithm wants."""

    def problems(self) -> Iterator[str]:
        stale_steps = int(self.loop.protection.stale_after_s / self.loop.period_s + 1e-9)
        stale_ticks, name = stale_steps * self.period_ticks, self.parts.name
        step_ticks = 2 * self.period_ticks
        yield from self._expect("before the first step", self._before_the_first_step(), 0)
        yield from self._expect("all is well", self._after(lambda: None, WELL_TICKS), WELL_TICKS)
        hang = self._after(self._hang, MAIN_TICKS + BEYOND_TICKS)
        yield from self._expect("the main loop hangs", hang, MAIN_TICKS)
        never = self._after(self._no_steps, step_ticks + BEYOND_TICKS)
        yield from self._expect("the control step never comes", never, step_ticks)
        blind = self._after(self._no_steps, stale_ticks + BEYOND_TICKS, f"gate_renew_{name}")
        yield from self._expect("steps without a reading", blind, stale_ticks + 1)
        idle = self._after(self._no_steps, step_ticks + BEYOND_TICKS, f"gate_renew_{name}_sensor")
        yield from self._expect("readings without a step", idle, step_ticks)
        yield from self._expect("a fault is latched", self._after(self._trip, 50), 0)
        if self.loop.fan:
            yield from self._expect("the fan stands still", self._after(self._stop_fan, 50), 0)
        yield from self._hang_mark()
        if self.parts.stepper:
            yield from self._halts()

    def _halts(self) -> Iterator[str]:
        """The feed is stopped in every tick in which nothing may be on."""
        self.run_at(COLD_C)
        for hangs, ticks, wanted in (
            (0, WELL_TICKS, 0),
            (1, MAIN_TICKS + BEYOND_TICKS, BEYOND_TICKS),
        ):
            self.host.world.main_hangs = hangs
            before = self.host.world.feed_halts
            self.full(ticks)
            if self.host.world.feed_halts - before != wanted:
                yield f"the feed is not stopped as it has to be; main loop hangs: {hangs}"

    def _hang_mark(self) -> Iterator[str]:
        """A mark tells of a hang after the reset that ends it, and of nothing else."""
        library, world = self.host.library, self.host.world
        self.run_at(COLD_C)
        for ticks, hangs in ((50, 0), (MAIN_TICKS - 1, 1), (1, 1), (50, 1), (1, 0)):
            world.main_hangs = hangs
            self.full(ticks)
            wanted = library.RESET_HANG_MARK if hangs and ticks != MAIN_TICKS - 1 else 0
            if library.reset_hang_mark != wanted:
                yield f"the hang mark is {library.reset_hang_mark:#x}, not {wanted:#x}"

    def _expect(self, when: str, found: int, wanted: int) -> Iterator[str]:
        if found != wanted:
            yield f"heater on for {found} ticks, not {wanted}, when {when}"

    def _before_the_first_step(self) -> int:
        self.host.renew()
        return self.full(self.period_ticks - 1)

    def _after(self, event: Callable[[], None], ticks: int, renew: str = "") -> int:
        """Heat at full power, let something happen, and count the ticks that heat goes on."""
        self.run_at(COLD_C)
        self.full(self.window_ticks)
        while self._left_of_period():
            self.full(1)
        event()
        return self.full(ticks, renew)

    def _left_of_period(self) -> int:
        return int(self.host.world.ticks) % self.period_ticks

    def _hang(self) -> None:
        self.host.world.main_hangs = 1

    def _no_steps(self) -> None:
        self.host.world.loop_hangs = 1

    def _stop_fan(self) -> None:
        self.host.world.fan_stands_still = 1

    def _trip(self) -> None:
        self.library.fault_trip(NO_SENSOR, COLD_C)
        self.host.world.loop_hangs = 1  # the gate alone must see it


MEMORY_DAMAGED, ON_TOO_LONG = 29, 30
COUNT_BITS = 32


def on_time_problem(host: Host) -> str:
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


FAULT = 6
WAYS, ONE = 1, 2  # programs that heat, the second with one segment
NEAR_C = 44.5  # where that has just reached its target, within its first 2 s
MOST_STEPS = 20
START_C = 30.0


def switching_problem(host: Host) -> str:
    parts, switching = host.build.parts, _Switching(host)
    checks = [switching.hanging()] if parts.cooler else []
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
