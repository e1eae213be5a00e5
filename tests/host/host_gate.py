"""Whether the gate lets a heater on only while every permit is fresh, to the tick.

The permits, from the design: the main loop may be silent for 100 ms, the control step for two
periods, the sensor for `stale_after`; a fault or a fan that stands still act at once.
"""

from collections.abc import Callable, Iterator

from heatwright.sim.host import Host

TICK_S = 0.01
MAIN_TICKS = 10
LONG = 5000
"""Ticks in which every permit runs out."""

NO_SENSOR = 1


def gate_problem(host: Host) -> str:
    """Say what the gate does wrong; empty if nothing."""
    return "; ".join(_Gate(host).problems())


class _Gate:
    def __init__(self, host: Host) -> None:
        self._host = host
        ((self._name, self._loop),) = host.build.controller.loops.items()
        self._period_ticks = round(self._loop.period_s / TICK_S)

    def problems(self) -> Iterator[str]:
        stale_ticks = round(self._loop.protection.stale_after_s / self._loop.period_s)
        yield from self._expect("before the first step", self._before_the_first_step(), 0)
        yield from self._expect("all is well", self._after(lambda: None, 300), 300)
        yield from self._expect("the main loop hangs", self._after(self._hang), MAIN_TICKS)
        yield from self._expect(
            "the control step never comes", self._after(self._no_steps), 2 * self._period_ticks
        )
        yield from self._expect(
            "the control step decides without a reading",
            self._after(self._no_steps, renew="gate_renew_air"),
            stale_ticks * self._period_ticks + 1,
        )
        yield from self._expect(
            "a reading is good, but no control step decides",
            self._after(self._no_steps, renew="gate_renew_air_sensor"),
            2 * self._period_ticks,
        )
        yield from self._expect("a fault is latched", self._after(self._trip, 50), 0)
        if self._loop.fan:
            yield from self._expect("the fan stands still", self._after(self._stop_fan, 50), 0)
        self._start()
        yield from self._hang_mark()

    def _hang_mark(self) -> Iterator[str]:
        """A mark tells of a hang after the reset that ends it, and of nothing else."""
        library, world = self._host.library, self._host.world
        for ticks, hangs in ((50, 0), (MAIN_TICKS - 1, 1), (1, 1), (50, 1), (1, 0)):
            world.main_hangs = hangs
            self._ticks(ticks)
            wanted = library.RESET_HANG_MARK if hangs and ticks != MAIN_TICKS - 1 else 0
            if library.reset_hang_mark != wanted:
                yield f"the hang mark is {library.reset_hang_mark:#x}, not {wanted:#x}"

    def _expect(self, when: str, found: int, wanted: int) -> Iterator[str]:
        if found != wanted:
            yield f"heater on for {found} ticks, not {wanted}, when {when}"

    def _start(self) -> None:
        world = self._host.world
        world.main_hangs = world.loop_hangs = world.fan_stands_still = 0
        self._host.erase()
        self._host.power_up()
        self._host.set_reading(0, 20 * 16)
        self._host.set_setpoint(60.0)

    def _before_the_first_step(self) -> int:
        self._start()
        return self._ticks(self._period_ticks - 1)

    def _after(self, event: Callable[[], None], ticks: int = LONG, renew: str = "") -> int:
        """Heat at full power, let something happen, and count the ticks that heat goes on."""
        self._start()
        for _ in range(3):
            self._host.step()
        event()
        return self._ticks(ticks, renew)

    def _ticks(self, ticks: int, renew: str = "") -> int:
        before = self._host.world.heater_counts
        for _ in range(ticks):
            self._host.library.host_tick()
            if renew:
                getattr(self._host.library, renew)()
        return int(self._host.world.heater_counts - before)

    def _hang(self) -> None:
        self._host.world.main_hangs = 1

    def _no_steps(self) -> None:
        self._host.world.loop_hangs = 1

    def _stop_fan(self) -> None:
        self._host.world.fan_stands_still = 1

    def _trip(self) -> None:
        self._host.library.fault_trip(NO_SENSOR, 20.0)
        self._host.world.loop_hangs = 1  # the gate alone must see it
