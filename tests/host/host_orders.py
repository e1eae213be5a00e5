"""Whether orders to a program are taken and refused as the page says, and act at once."""

from collections.abc import Callable, Iterator
from random import Random

from host_running import Running

from heatwright.sim.host import Host
from heatwright.sim.reference.program_state import (
    IDLE,
    JUMP,
    PAUSE,
    PAUSED,
    RESTORING,
    RESUME,
    RETURNING,
    RUNNING,
    SKIP,
    START,
    STOP,
)
from heatwright.spec import starts_enabled

RANDOM_ORDERS = 4000
FAULT = 6
WAYS, ONE, HOLDS = 1, 2, 3
"""Programs: two that heat, the second with one segment; one that holds. The seventh is the last."""
NEAR_C = 44.5
"""Where that has just reached its target, within its first 2 s."""
MOST_STEPS = 20
PLACES = 7
START_C, LEAST_C = 30.0, 10.0


def orders_problem(host: Host) -> str:
    """Say the first thing that is wrong; empty if nothing, or if a master switches it."""
    orders = _Orders(host)
    checks = [orders.pressed()]
    if host.build.parts.programmed:
        checks += [orders.at_once(), orders.finished(), orders.refused(), orders.others_refused()]
        checks += [orders.too_hot(), orders.skipped()]
    return next((problem for check in checks for problem in check), "")


class _Orders(Running):
    def __init__(self, host: Host) -> None:
        super().__init__(host)
        self._waits = 0
        if not host.build.parts.programmed:
            return
        library = host.library
        self._give: dict[int, Callable[[int], bool]] = {
            STOP: lambda _: library.program_stop(),
            PAUSE: lambda _: library.program_pause(),
            START: library.program_start,
            RESUME: lambda _: library.program_resume(),
            SKIP: lambda _: library.program_skip(),
            JUMP: library.program_jump,
        }

    def _fire(self) -> None:
        """Be in a program that heats: held back far below, or full on."""
        self.host.world.main_hangs = self.host.world.loop_hangs = 0
        self.host.erase()
        self.host.power_up()
        self.host.set_reading(0, self.scale.code(START_C))
        self.host.step()
        self.library.program_start(WAYS)
        self.host.step()
        self.host.set_reading(0, self.scale.code(START_C - 2.5))
        for _ in range(3):
            self.host.step()

    def at_once(self) -> Iterator[str]:
        """Stop, pause and off do not wait for the step that takes them over."""
        events: dict[str, Callable[[], object]] = {
            "stop": self.library.program_stop,
            "pause": self.library.program_pause,
            "off": self.library.loop_air_disable,
        }
        for name, event in events.items():
            self._fire()
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
        self.run_at(NEAR_C)
        self.library.loop_air_disable()
        self.host.step()
        self.library.program_start(ONE)
        heated = 0
        for _ in range(MOST_STEPS):
            self.host.step()
            if self.library.program.ended:
                break
            heated = self.ticks(1)[0]
        if not heated or self.ticks(self.period_ticks - 1)[0]:
            yield f"finished after {heated} ticks of heat, and it is held on"

    def skipped(self) -> Iterator[str]:
        """A last ramp that is skipped leads no further, though the end be held."""
        assert self.host.build.controller.programs is not None
        if self.host.build.controller.programs.at_end != "hold":
            return
        self.run_at(START_C)
        self.library.loop_air_disable()
        self.host.step()
        self.library.program_start(ONE)
        self.host.step()
        self.host.step()
        came_to_c, to_c = self.library.program.setpoint_c, self.library.program.to_c
        self.library.program_skip()
        self.host.step()
        held = (self.library.loop_air.setpoint_c, self.library.settings.air_setpoint_c)
        if came_to_c == to_c or held != (came_to_c, came_to_c):
            yield f"skipped on the way from {came_to_c} to {to_c} °C, it holds {held}"

    def too_hot(self) -> Iterator[str]:
        """A program that only holds does not hold what nobody may set."""
        most_c, trips_c = self.loop.setpoint.maximum_c, self.loop.protection.maximum_c
        assert trips_c is not None
        for here_c in (most_c - 1.0, 0.5 * (most_c + trips_c)):
            code = self.scale.code(here_c)
            self.host.erase()
            self.host.power_up()
            self.host.set_reading(0, code)
            self.host.step()
            self.library.program_start(HOLDS)
            self.host.step()
            if self.library.program.setpoint_c != min(self.scale.celsius(code), most_c):
                yield f"begun at {here_c}: it holds {self.library.program.setpoint_c}"

    def pressed(self) -> Iterator[str]:
        """Nobody has to press off first; but nothing heats again by itself."""
        library = self.library
        self.host.erase()
        self.host.power_up()
        if library.loop_air_is_enabled() != starts_enabled(self.host.build.controller, "air"):
            yield "after a reset it is not as it should start"
        for _ in range(2):
            if not library.loop_air_enable() or not library.loop_air_is_enabled():
                yield "it cannot be switched on"
            library.fault_trip(FAULT, START_C)
            if library.loop_air_may_enable() or library.loop_air_enable():
                yield "it is switched on with a fault latched"
            library.fault_acknowledge()
            if library.loop_air_is_enabled():
                yield "it heats again by itself"

    def refused(self) -> Iterator[str]:
        """Orders one after the other, and what each of them says."""
        random = Random("orders")  # noqa: S311
        self._fire()
        for _ in range(RANDOM_ORDERS):
            yield from self._anything(random)

    def _anything(self, random: Random) -> Iterator[str]:
        library = self.library
        if random.random() < 0.02:
            self.host.library.host_settle()
            self.host.power_up()
            self._waits = 0
        if random.random() < 0.5:
            status = random.choice((0, 0, 0, 1))
            near_c = float(library.program.setpoint_c) + random.choice((0.0, 0.0, 3.0))
            had_fault = library.fault.code
            self.host.set_reading(status, self.scale.code(max(LEAST_C, near_c)))
            self.host.step()
            if not status or self._waits in (STOP, PAUSE) or had_fault:
                self._waits = 0
        elif random.random() < 0.05:
            library.fault_trip(FAULT, START_C)
        elif random.random() < 0.2:
            self._waits = 0 if library.fault.code else self._waits
            library.fault_acknowledge()
        order, number = random.choice((*self._give, START)), random.randint(0, 9)
        wanted = self._may(order, number)
        if self._give[order](number) != wanted:
            yield f"order {order} {number} in state {library.program.state}: not {wanted}"
        if wanted:
            self._waits = order
        elif order == START and library.program.state == IDLE and not self._keeps_off(order):
            self._waits = 0 if not library.fault.code else self._waits

    def _may(self, order: int, number: int) -> bool:
        library = self.library
        state = library.program.state
        if order == STOP:
            return bool(state != IDLE or self._waits)
        fits = {
            PAUSE: state in (RUNNING, RETURNING) or self._waits in (START, RESUME),
            START: state == IDLE and 1 <= number <= PLACES,
            RESUME: state == PAUSED,
            SKIP: state == RUNNING,
            JUMP: state not in (IDLE, RESTORING) and 1 <= number <= library.program.segments,
        }
        return fits[order] and not library.fault.code and not self._keeps_off(order)

    def _keeps_off(self, order: int) -> bool:
        return self._waits == STOP or (self._waits == PAUSE and order != PAUSE)

    def others_refused(self) -> Iterator[str]:
        """While a program is active the loop's own commands are refused, but for off."""
        library = self.library
        commands: dict[str, Callable[[], bool]] = {
            "setpoint": lambda: library.loop_air_set(40.0),
            "on": library.loop_air_enable,
        }
        if self.parts.tunable:
            commands["by hand"] = lambda: library.loop_air_set_manual(50.0)
        self._fire()
        for name, command in commands.items():
            if command():
                yield f"{name}: taken while a program runs"
        if library.loop_air_may_set(40.0) or library.loop_air_may_enable():
            yield "it says that its own commands may be given while a program runs"
        self.host.step()
        if library.program.state != RUNNING:
            yield "its own commands disturb the program"
        library.program_stop()
        self.host.step()
        for name, command in commands.items():
            if not command():
                yield f"{name}: refused although the program is stopped"
