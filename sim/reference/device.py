"""The reference model as a device, which can replace the binary on the bench."""

from collections.abc import Callable, Mapping

from heatwright.sim.reference.inputs import Gains
from heatwright.sim.reference.interfaces.gcode import Host
from heatwright.sim.reference.interfaces.modbus_rtu import Master
from heatwright.sim.reference.interfaces.nextion import Display
from heatwright.sim.reference.interfaces.pages import CountdownKeys, MenuKeys, Pages
from heatwright.sim.reference.interfaces.switched import SwitchedOperator
from heatwright.sim.reference.modelled_loop import Feels, ModelledLoop
from heatwright.sim.reference.numbers import FULL, SECOND_US, ZERO, Single
from heatwright.sim.reference.outputs.driven import Clock, Driven, Feed
from heatwright.sim.reference.programs.orders import ProgrammedOperator
from heatwright.sim.reference.protection.latch import Latch
from heatwright.sim.trace import StepLog
from heatwright.spec import Controller, facts_of, for_display
from heatwright.spec.scenario.program_orders import Order

REST_US, PRESS_US = 1_000_000, (80_000, 2_000_000)
"""SELECT acknowledges a fault that was latched when it was pressed, if all keys had been released
for this long before, and SELECT is released within these times."""


class ReferenceDevice:
    """The control equations of all loops, with ideal timing and ideal sensors.

    Control steps run at whole multiples of a loop's period after power-up; at the same time, in the
    order of the loops in the spec. Keys, lines from a host or a display, a master's writes and
    commands to a program act at once. A fault of one loop switches all heaters off at once.
    Raises KeyError, in each method with the name of a loop: there is no such loop.
    """

    def __init__(
        self,
        controller: Controller,
        noise_k: Mapping[str, float] | None = None,
        most_rows: int | None = None,
        feels: Feels | None = None,
    ) -> None:
        """Power up.

        noise_k -- by sensor: noise added at each reading, K, if the machine makes none; most_rows
        -- how many steps of each loop are kept, None: all; feels -- the sensors' values at
        `now_s`, None: those set by `sense`.
        """
        noise_k = noise_k or {}
        self._felt = dict.fromkeys(controller.sensors, 0.0)
        felt = self._felt if feels is None else feels
        self._loops = {
            name: ModelledLoop(controller, name, felt, noise_k.get(loop.sensor, 0.0), most_rows)
            for name, loop in controller.loops.items()
        }
        self._due_us = min(loop.due_us for loop in self._loops.values())
        self._controller = controller
        self._latch = Latch(controller, self._loops)
        self._driven, self._feeds = _outputs(controller, self._latch)
        self._host = Host(controller, self._loops, self._latch, self._driven, self._feeds)
        self._master = self._master_of(controller)
        self._display = self._display_of(controller)
        self._keypad = facts_of(controller).keypad
        self._pages = self._pages_of(controller)
        leads = self._keypad is not None and facts_of(controller, self._keypad.loop).programmed
        self._menu = MenuKeys() if leads else None
        self._key: str | None = None
        self._key_us = 0
        self._rested = False
        self.fault_loop = ""
        """Name of the loop in whose control step the first fault was latched; empty: none yet."""

    def _master_of(self, controller: Controller) -> Master | None:
        if facts_of(controller).modbus is None:
            return None
        operators = {
            name: loop.operator
            for name, loop in self._loops.items()
            if isinstance(loop.operator, SwitchedOperator)
        }
        return Master(controller, operators, self._latch.acknowledge)

    def _display_of(self, controller: Controller) -> Display | None:
        nextion = facts_of(controller).nextion
        if nextion is None:
            return None
        operator = self._loops[nextion.loop].operator
        return Display(controller, operator, self._latch.acknowledge)

    def _pages_of(self, controller: Controller) -> Pages:
        if self._keypad is None:
            return Pages(None, ())
        return Pages(self.countdown, facts_of(controller, self._keypad.loop).keyed_numbers)

    @property
    def page(self) -> str:
        """What UP and DOWN change: the key of a number, `time`, or "" for the setpoint."""
        return self._pages.page

    @property
    def numbers(self) -> Mapping[str, Single]:
        """The numbers that the keypad has set, by field of the algorithm."""
        return self._pages.values

    @property
    def countdown(self) -> CountdownKeys | None:
        """The countdown that the keys can set, or None."""
        return None if self._keypad is None else self._loops[self._keypad.loop].countdown

    def is_off(self, loop: str) -> bool:
        """Return whether a loop will be off in its next step."""
        return self._loops[loop].operator.is_off

    @property
    def now_s(self) -> float:
        """The time, s since power-up."""
        return self._latch.now_us / SECOND_US

    @property
    def fault(self) -> int:
        """The latched fault, 0 for none."""
        return self._latch.code

    def ask(self, loop: str, setpoint_c: float) -> None:
        """Set a loop's setpoint, °C, and switch it on, as any of its interfaces could."""
        operator = self._loops[loop].operator
        operator.set(setpoint_c)
        if isinstance(operator, SwitchedOperator):
            operator.switch(on=True)

    def switch_off(self, loop: str) -> None:
        """Switch a loop off, as its keys would."""
        self._loops[loop].operator.key_off()

    def last(self, loop: str, member: str) -> float:
        """Return a member of a loop's last step.

        Raises ValueError: its steps have no such member, or there was no step.
        """
        return self._loops[loop].last(member)

    def gains(self, loop: str) -> Gains | None:
        """Return the gains of a loop now, if they can be changed."""
        return self._loops[loop].operator.gains

    def sense(self, sensor: str, felt: float) -> None:
        """Set a sensor's temperature, °C, or current, A, from now on."""
        self._felt[sensor] = felt

    def press(self, key: str | None) -> None:
        """Hold a key, or none, from now on."""
        pressed = key is not None and key != self._key
        meant = self._meant_by_select(key)
        if self._latch.code and meant is not None:
            self._pages.take("select")
            meant()
        if self._keypad is None or not pressed or self._latch.code:
            return
        operator, step_k = self._loops[self._keypad.loop].operator, Single(self._keypad.step_k)
        if self._menu is not None:
            self._choose(self._menu.moves(key) * step_k)
            return
        if self._pages.take(key):
            self._loops[self._keypad.loop].operator.numbers = self._pages.values
            return
        if key == "up":
            operator.change(step_k)
        elif key == "down":
            operator.change(-step_k)
        elif key == "left":
            operator.key_off()

    def _meant_by_select(self, key: str | None) -> Callable[[], None] | None:
        """Process a change of the pressed key; return the action of a released SELECT, if any."""
        if key == self._key:
            return None
        lasted_us, meant = self._latch.now_us - self._key_us, None
        if self._key == "select" and self._rested and self._keypad is not None:
            ways = {
                PRESS_US: self._latch.acknowledge,
                self._latch.lockout.hold_us: self._latch.release,
            }
            found = (does for (least, most), does in ways.items() if least <= lasted_us <= most)
            meant = next(found, None)
        rested = self._key is None and lasted_us >= REST_US
        self._rested = rested and self._latch.code != 0
        self._key, self._key_us = key, self._latch.now_us
        return meant

    def _choose(self, by_k: Single) -> None:
        """Change the setpoint of a loop with programs; this is refused while a program runs."""
        if self._keypad is not None and by_k:
            loop = self._loops[self._keypad.loop]
            ends, wanted_c = loop.spec.setpoint, loop.operator.setpoint_c + by_k
            loop.operator.set(min(max(float(wanted_c), ends.minimum_c), ends.maximum_c))

    def send(self, line: str) -> None:
        """Send a line of G-code, or a display's command; a refused one changes nothing.

        Raises ValueError: the controller has neither host nor display, or the line no command.
        """
        if self._display is not None and for_display(self._controller, line):
            self._display.send(line)
        else:
            self._host.send(line)
            self._mind_fault()

    def program(self, order: Order, number: int = 0) -> None:
        """Give a command to the program; one that the firmware would refuse changes nothing.

        Raises ValueError: the controller has no programs.
        """
        for loop in self._loops.values():
            if isinstance(loop.operator, ProgrammedOperator):
                loop.operator.order(order, number)
                return
        raise ValueError("The specification has no programs")

    def write(self, name: str, value: float | bool) -> None:
        """Write a value as the master; one that the firmware would refuse changes nothing.

        Raises ValueError: the controller has no master; KeyError: there is no value of that name.
        """
        if self._master is None:
            raise ValueError("The specification has no modbus_rtu interface")
        self._master.write(name, value)

    def advance(self, until_s: float) -> None:
        """Run to a time since power-up, s. What is due at exactly that time is done later."""
        until_us = round(until_s * SECOND_US)
        loops = self._loops.values()
        while (due_us := self._due_us) < until_us:
            for loop in loops:
                while loop.due_us == due_us:
                    self._latch.now_us = due_us
                    if loop.do():
                        self._after_step(loop)
            self._due_us = min(loop.due_us for loop in loops)
        self._latch.now_us = until_us

    def on_fraction(self, output: str) -> float:
        """Return the mean active fraction (0..1) of an output since the last call."""
        return self._driven[output].on_fraction()

    def relay_fraction(self) -> float:
        """Return 1: an ideal relay is closed whenever a heater is on."""
        return 1.0

    def travel_mm(self, output: str) -> float:
        """Return a stepper's feed since the last call, mm."""
        return self._feeds[output].travel_mm()

    def steps(self, loop: str) -> StepLog:
        """Return a row for every control step so far."""
        return self._loops[loop].steps()

    def _after_step(self, loop: ModelledLoop) -> None:
        """Set the outputs by the decisions of a step."""
        self._driven[loop.spec.heater].take(loop.reference.output.counts)
        if loop.spec.cooler is not None:
            self._driven[loop.spec.cooler].set(FULL if loop.reference.cooling else ZERO)
        if loop.reference.fault_code and not self.fault_loop:
            self.fault_loop = loop.name
        self._latch.take(loop)
        self._mind_fault()
        waited_for = [each for each in self._loops.values() if each.spec.ready_within_k]
        for feed in self._feeds.values():
            feed.permit(may_run=all(each.is_ready for each in waited_for))

    def _mind_fault(self) -> None:
        """Switch off all heaters, and stop all motors, while a fault is latched."""
        if not self._latch.code:
            return
        for loop in self._loops.values():
            self._driven[loop.spec.heater].take(0)
        for feed in self._feeds.values():
            feed.forget()


def _outputs(controller: Controller, clock: Clock) -> tuple[dict[str, Driven], dict[str, Feed]]:
    driven = {name: Driven(controller, name, clock) for name in controller.switches}
    return driven, {name: Feed(stepper, clock) for name, stepper in controller.steppers.items()}
