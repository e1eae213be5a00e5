"""The binary as a device on the bench: a simulated processor with the spec's chips and wires."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.avr import CAUSES, Avr
from heatwright.sim.binary.dwarf import Variable, Variables
from heatwright.sim.binary.elf import Elf, ElfError
from heatwright.sim.contact import contacts_of
from heatwright.sim.interfaces.gcode import GcodeHost
from heatwright.sim.interfaces.lcd_keypad import LcdKeypad
from heatwright.sim.interfaces.lcd_keypad.keypad import keys_for
from heatwright.sim.interfaces.look import NO_LOOK, Look
from heatwright.sim.interfaces.modbus_rtu import ModbusMaster
from heatwright.sim.interfaces.nextion import Nextion
from heatwright.sim.interfaces.serial_log import SerialLog
from heatwright.sim.interfaces.serial_plotter import SerialPlotter
from heatwright.sim.judges.interlock import Interlock
from heatwright.sim.outputs.stepper import Stepper
from heatwright.sim.outputs.switch import Switch
from heatwright.sim.proof import proofs_of
from heatwright.sim.relay import SafetyRelay
from heatwright.sim.state import StateLog
from heatwright.sim.trace import StepLog
from heatwright.spec import Controller, digest, for_display
from heatwright.spec.registry import module_of
from heatwright.spec.scenario.program_orders import Order, ProgramOrder

DIGEST = "spec_digest"
"""Constant in flash: CRC-32 of the spec from which the binary was generated."""
PROOF = "reset_prove_watchdog"
"""The function that proves at start-up that the watchdog resets."""
FEED_S = 10.0
"""Longest simulated time, s, until parts that act get the new records."""
LISTEN_S = 60.0
"""How often parts that only listen get the new records, unless they are requested: larger blocks
are less work. A heater's PWM makes about one megabyte."""


Kind = TypeVar("Kind")


class StaleBinary(ValueError):
    """The binary was generated from another spec; the message says what to do."""


class Sensor(Protocol):
    """A simulated sensor."""

    def sense(self, felt: float, /) -> None:
        """Set its temperature, °C, or current, A, from now on."""

    @property
    def violations(self) -> Mapping[str, int]:
        """Count violations of the data sheet's timing, by phase; none without a protocol."""


class Listener(Protocol):
    """A part that gets the records of the pins and the serial lines."""

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Process pin changes (PIN_EVENT) and the bytes that the UARTs sent (UART_BYTE)."""


class Interface(Listener, Protocol):
    """A simulated display, keypad or line."""

    @property
    def complaints(self) -> Iterable[str]:
        """Return violations of a data sheet, and messages that could not be understood."""


@runtime_checkable
class Waker(Listener, Protocol):
    """A part that acts at times of its own, when it gets the records."""

    wake_cycle: int | None
    """The cycle at which it next acts; None: it waits for nothing."""


@runtime_checkable
class Talker(Waker, Protocol):
    """A part that has exchanges with the board."""

    is_busy: bool
    """Whether it is in an exchange: it gets the records at the end of each time step."""


@runtime_checkable
class Partner(Waker, Protocol):
    """A part that needs the whole spec, on a serial line that a real partner may take over."""

    look: Look | None
    """How C may look in its place while it only waits for the board, otherwise None."""
    is_plugged: bool

    def learn(self, controller: Controller) -> None:
        """Take over what it must know of the spec: a master, the registers of its slave."""

    def unplug(self) -> None:
        """Disconnect it from the line."""


class _InterfaceOf(Generic[Kind]):
    """The interface of one kind, as an attribute of its device."""

    def __init__(self, kind: type[Kind]) -> None:
        self._kind = kind

    def __get__(self, device: "AvrDevice", _: type) -> Kind:
        return device.interface(self._kind)


class AvrDevice:
    """A spec's controller, running an unmodified binary in a simulated processor.

    elf -- the binary, with debug information. The device starts powered on, at time 0.
    avr -- the processor; feed_at -- the latest cycle at which the records are read; sensors,
    outputs, interfaces -- the parts wired to it, by the spec's names; relay -- the safety relay, if
    any; proofs -- the proofs of fans, by the fan; contacts -- those at the machine's inputs, by
    their names; looked_at -- the variables read so far, cleared by the caller that uses it; edged
    -- the outputs whose changes are logged; crystal_hz -- the crystal's frequency from the next
    power-up on.

    Raises StaleBinary: the binary was generated from another spec; ElfError: it is no AVR program
    or lacks what the simulation reads; SimulatorMissing: there is no simulator.
    """

    def __init__(self, controller: Controller, elf: Path | str | Elf) -> None:
        self._controller = controller
        self.elf = elf if isinstance(elf, Elf) else Elf(elf)
        self.variables = Variables(self.elf)
        self.looked_at: dict[str, Variable] = {}
        check_digest(self.elf, digest(controller))
        self.edged = {
            name
            for loop in controller.loops.values() if loop.cooler is not None
            for name in (loop.heater, loop.cooler)
        }  # fmt: skip
        self.crystal_hz = controller.board.clock_hz
        self._start_s = 0.0
        self._recorders: list[Any] = []
        self._logs = {
            loop: StateLog(self.elf, self.variables, controller, loop) for loop in controller.loops
        }
        self._resets: list[NDArray[Any]] = []
        self.interlocks: dict[str, Interlock] = {}
        self.relay = SafetyRelay() if controller.safety.relay is not None else None
        self.proofs = proofs_of(controller)
        self.contacts = contacts_of(controller)
        self._power_on(b"")

    def _power_on(self, eeprom: bytes) -> None:
        controller = self._controller
        self.avr = Avr(controller.board.mcu, self.crystal_hz)
        self.avr.load(self.elf)
        if eeprom:
            self.avr.eeprom.contents = eeprom
        self.sensors = self._attach("sensor", controller.sensors)
        found = self._attach("output", controller.outputs)
        self.outputs: dict[str, Switch] = found
        self._motors: dict[str, Stepper] = {each: found[each] for each in controller.steppers}
        self.log_edges(self.edged)
        if self.relay is not None:
            self.relay.power_on(self.avr, controller)
        for part in (*self.proofs.values(), *self.contacts.values()):
            part.power_on(self.avr, controller)
        numbered = dict(enumerate(controller.interfaces))
        self.interfaces: list[Interface] = list(self._attach("interface", numbered).values())
        self._held: list[tuple[NDArray[Any], NDArray[Any]]] = []
        self._listeners = [each for each in self.interfaces if not isinstance(each, Waker)]
        self._wakers: list[Waker] = [each for each in self.interfaces if isinstance(each, Waker)]
        self._talkers = [each for each in self.interfaces if isinstance(each, Talker)]
        self._partners = [each for each in self.interfaces if isinstance(each, Partner)]
        self._watch_interlocks()
        for partner in self._partners:
            partner.learn(controller)
        for log in self._logs.values():
            log.record(self.avr, self._start_s)
        self.feed_at = self._listen_at = 0

    def _watch_interlocks(self) -> None:
        for name, loop in self._controller.loops.items():
            if loop.cooler is None:
                continue
            watch = self.interlocks.setdefault(
                name,
                Interlock(self.outputs[loop.heater], self.outputs[loop.cooler], self.avr.clock_hz),
            )
            watch.power_on(self._start_s)

    def _attach(self, role: str, parts: Any) -> dict[Any, Any]:
        """Create each part's simulation by its kind."""
        board = self._controller.board
        return {
            name: import_module(module_of(role, "simulated", part.kind)).attach(
                self.avr, board, part
            )
            for name, part in parts.items()
        }

    # -- the bench -----------------------------------------------------------------------------

    def sense(self, sensor: str, felt: float) -> None:
        """Set a sensor's temperature, °C, or current, A, from now on."""
        self.sensors[sensor].sense(felt)

    def press(self, key: str | None) -> None:
        """Hold a key of the keypad: right, up, down, left, select; None: none."""
        self.shield.keypad.press(key)

    def send(self, line: str) -> None:
        """Send a line of G-code as the host, after the lines before it are answered.

        A command of the touch display ("#8 1;") is sent by the display, unchanged and at once.
        """
        if for_display(self._controller, line):
            self.parts(Nextion)[0].send(line)
        else:
            self.host.send(line)

    def program(self, order: Order, number: int = 0) -> None:
        """Give a command to the program as the operator; number -- the program or the segment.

        The command goes by the touch display or, without one, by the menu of the shield's keypad.
        """
        for display in self.parts(Nextion):
            display.order(order, number)
            return
        self.shield.play(keys_for(ProgramOrder(order, number)))

    def write(self, name: str, value: float | bool) -> None:
        """Write a value as the master, such as nozzle.setpoint, as soon as the line is free."""
        self.master.write(name, value)

    def unplug(self) -> None:
        """Disconnect the simulated master or display, so that the line is free for another."""
        for partner in self._partners:
            partner.unplug()

    def parts(self, kind: type[Kind]) -> list[Kind]:
        """Return the interfaces of a kind."""
        return [part for part in self.interfaces if isinstance(part, kind)]

    def cycle_at(self, time_s: float) -> int:
        """Return the processor's cycle at a time since the device was made, s."""
        return round((time_s - self._start_s) * self.avr.clock_hz)

    def advance(self, until_s: float) -> None:
        """Run to a time since the device was made, s."""
        cycle = self.cycle_at(until_s)
        while True:
            wake, look = self.wakes
            end = cycle if wake is None else min(wake, cycle)
            if not self.avr.run_looking(look, end):
                self.avr.run_to(end)
                if wake is None or wake >= cycle:
                    break
            self.hear()
        if cycle >= self.feed_at or self.is_attended:
            self.listen()

    @property
    def is_attended(self) -> bool:
        """Whether a part is in the middle of an exchange with the board."""
        return any(part.is_busy for part in self._talkers)

    @property
    def wake_cycle(self) -> int | None:
        """The cycle at which a part next reads the records and acts, or a key is released."""
        return _first_wake(self._wakers)

    @property
    def wakes(self) -> tuple[int | None, Look]:
        """`wake_cycle`, but not of a part that waits for the board; and the look of that part."""
        for part in self._partners:
            if (look := part.look) is not None:
                return _first_wake(each for each in self._wakers if each is not part), look
        return self.wake_cycle, NO_LOOK

    def on_fraction(self, output: str) -> float:
        """Return the mean active fraction (0..1) of an output since the last call."""
        return self.outputs[output].on_fraction()

    def relay_fraction(self) -> float:
        """Return the share of time the safety relay has conducted since the last call, 0..1."""
        return self.relay.closed_fraction() if self.relay is not None else 1.0

    def travel_mm(self, output: str) -> float:
        """Return how far a stepper has fed since the last call, mm; 0 for any other output."""
        stepper = self._motors.get(output)
        if stepper is None:
            return 0.0
        if stepper.waits:
            self.feed()
        return stepper.travel_mm()

    def steps(self, loop: str) -> StepLog:
        """Return one row for each control step so far."""
        return self._logs[loop].steps()

    def take_steps(self, loop: str) -> StepLog:
        """Return one row for each control step since the last call, and delete them."""
        return self._logs[loop].take()

    @property
    def uart(self) -> int:
        """The number of the UART of the first interface with a serial line."""
        ports = (each.line.port for each in self._controller.interfaces if each.line is not None)
        return self._controller.board.uarts[next(ports, 0)].number

    # -- state ---------------------------------------------------------------------------------

    @property
    def powered_s(self) -> float:
        """When its power last came on, s since the device was made."""
        return self._start_s

    @property
    def time_s(self) -> float:
        """Time since the device was made, s."""
        return self._start_s + self.avr.time_s

    # Each raises LookupError: the spec has no such interface.
    shield = _InterfaceOf(LcdKeypad)
    plotter = _InterfaceOf(SerialPlotter)
    log_reader = _InterfaceOf(SerialLog)
    host = _InterfaceOf(GcodeHost)
    master = _InterfaceOf(ModbusMaster)
    display = _InterfaceOf(Nextion)

    def interface(self, kind: type[Kind]) -> Kind:
        """Return the interface of a kind, with all records so far."""
        self.feed()
        for interface in self.interfaces:
            if isinstance(interface, kind):
                return interface
        raise LookupError(f"{self._controller.identity.name} has no {kind.__name__}.")

    def read(self, name: str) -> Any:
        """Return the present value of a program's variable, by its name in the source."""
        variable = self.looked_at[name] = self.variables[name]
        raw = self.avr.read_ram(variable.address, variable.size)
        return np.frombuffer(raw, variable.dtype)[0]

    def hear(self) -> None:
        """Give the new records to the parts that act; other parts get them with the next feed."""
        pins, sent = self.avr.pins.take(), self.avr.uarts.take()
        for part in self._wakers:
            part.feed(pins, sent)
        self._held.append((pins, sent))

    def listen(self) -> None:
        """Give the new records to the parts that act, or to all parts if that is due."""
        if self.avr.cycle >= self._listen_at:
            self.feed()
            return
        self.hear()
        if self.avr.cycle >= self.feed_at:
            self.feed_at = self._after(FEED_S)

    def feed(self) -> None:
        """Give the new records to all interfaces and recorders."""
        self.hear()
        pins, sent = (_joined(parts) for parts in zip(*self._held, strict=True))
        self._held.clear()
        whole = (*self._listeners, *self._motors.values(), *self.interlocks.values())
        for part in (*whole, *self._recorders):
            part.feed(pins, sent)
        self.feed_at, self._listen_at = self._after(FEED_S), self._after(LISTEN_S)

    def _after(self, seconds: float) -> int:
        return self.avr.cycle + round(seconds * self.avr.clock_hz)

    def record(self, recorder: Listener) -> None:
        """Give a recorder all records from now on (see heatwright.sim.plots.vcd)."""
        self.feed()
        self._recorders.append(recorder)

    def log_edges(self, outputs: Collection[str]) -> None:
        """Log the changes of these outputs' pins from now on, also after a loss of power."""
        self.edged |= set(outputs)
        for name in outputs:
            self.outputs[name].log_edges()

    def take_resets(self) -> NDArray[Any]:
        """Return the resets since the last call (RESET_EVENT), without the start-up test's own."""
        resets = self.avr.take_resets()
        proof = [each for each in self.elf.functions if each.name == PROOF]
        awaited = [any(each.start <= place < each.end for each in proof) for place in resets["pc"]]
        by_others = resets["cause"] != CAUSES.index("watchdog")
        others: NDArray[Any] = resets[by_others | ~np.array(awaited, bool)]
        return others

    # -- power ---------------------------------------------------------------------------------

    def power_cycle(self, undefined: int = 0xFF) -> None:
        """Cut the power and restore it: all but the EEPROM starts again.

        undefined -- the value of an EEPROM byte that was being written at the cut.
        """
        self.feed()
        eeprom = self.avr.eeprom.after_power_cut(undefined)
        for log in self._logs.values():
            log.collect()
        self._start_s = self.time_s
        plugged = all(part.is_plugged for part in self._partners)
        self._power_on(eeprom)
        if not plugged:
            self.unplug()


def _first_wake(parts: Iterable[Waker]) -> int | None:
    return min((wake for part in parts if (wake := part.wake_cycle) is not None), default=None)


def _joined(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Concatenate records and keep their padding, which numpy's own function would remove."""
    some = [part for part in parts if len(part)]
    if len(some) < 2:
        return some[0] if some else parts[0]
    return np.concatenate(some, dtype=some[0].dtype)


def check_digest(program: Elf, expected: str) -> None:
    """Raise StaleBinary when the program was generated from another spec."""
    found = f"{int.from_bytes(program.flash_bytes(DIGEST, 4), 'little'):08x}"
    if found != expected:
        raise StaleBinary(
            f"{program.path.name} was generated from another spec (digest {found}, not {expected}):"
            " generate and build it again."
        )


__all__ = ["AvrDevice", "ElfError", "StaleBinary", "check_digest"]
