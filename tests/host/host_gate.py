"""Whether the gate lets a heater on only while every permit is fresh, to the tick.

The permits, from the design: the main loop may be silent for 100 ms, the control step for two
periods, the sensor for `stale_after`; a fault or a fan that stands still act at once.
"""

from collections.abc import Callable, Iterator

from host_scale import scale_of

from heatwright.sim.host import Command, Host

HOT_C, COLD_C, TARGET_C = 240.0, 60.0, 150.0
LONG = 3000
"""Ticks in which every permit runs out."""
MAIN_TICKS = 10
BEYOND_TICKS = 60
"""Watched after every permit has run out."""
WELL_TICKS = 15
"""More than the main loop may be silent for, and too few for any rule to trip."""
NO_SENSOR = 1


class Running:
    """A loop that is switched on and runs, at a temperature."""

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
        """Power up, switch on, and do a few steps at a temperature."""
        host = self.host
        host.world.main_hangs = host.world.loop_hangs = host.world.fan_stands_still = 0
        host.erase()
        host.power_up()
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


def gate_problem(host: Host) -> str:
    """Say the first thing that the gate does wrong; empty if nothing."""
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
            self._full(ticks)
            if self.host.world.feed_halts - before != wanted:
                yield f"the feed is not stopped as it has to be; main loop hangs: {hangs}"

    def _hang_mark(self) -> Iterator[str]:
        """A mark tells of a hang after the reset that ends it, and of nothing else."""
        library, world = self.host.library, self.host.world
        self.run_at(COLD_C)
        for ticks, hangs in ((50, 0), (MAIN_TICKS - 1, 1), (1, 1), (50, 1), (1, 0)):
            world.main_hangs = hangs
            self._full(ticks)
            wanted = library.RESET_HANG_MARK if hangs and ticks != MAIN_TICKS - 1 else 0
            if library.reset_hang_mark != wanted:
                yield f"the hang mark is {library.reset_hang_mark:#x}, not {wanted:#x}"

    def _expect(self, when: str, found: int, wanted: int) -> Iterator[str]:
        if found != wanted:
            yield f"heater on for {found} ticks, not {wanted}, when {when}"

    def _before_the_first_step(self) -> int:
        self.host.erase()
        self.host.power_up()
        return self._full(self.period_ticks - 1)

    def _after(self, event: Callable[[], None], ticks: int, renew: str = "") -> int:
        """Heat at full power, let something happen, and count the ticks that heat goes on."""
        self.run_at(COLD_C)
        self._full(self.window_ticks)
        while self._left_of_period():
            self._full(1)
        event()
        return self._full(ticks, renew)

    def _left_of_period(self) -> int:
        return int(self.host.world.ticks) % self.period_ticks

    def _full(self, ticks: int, renew: str = "") -> int:
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

    def _hang(self) -> None:
        self.host.world.main_hangs = 1

    def _no_steps(self) -> None:
        self.host.world.loop_hangs = 1

    def _stop_fan(self) -> None:
        self.host.world.fan_stands_still = 1

    def _trip(self) -> None:
        self.library.fault_trip(NO_SENSOR, COLD_C)
        self.host.world.loop_hangs = 1  # the gate alone must see it
