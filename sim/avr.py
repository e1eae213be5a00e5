"""A simulated AVR: libsimavr behind a shim that makes it behave like the real part.

The run loop is in C and does not hold Python's lock, so processors run in threads side by side;
each is independent and deterministic. See docs/simulator.md for what is and is not simulated.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.binary.elf import Elf, Function
from heatwright.sim.binary.profile import Profile
from heatwright.sim.interfaces.look import NEVER, Look
from heatwright.sim.native import spi
from heatwright.sim.native.analog import Adc
from heatwright.sim.native.eeprom import Eeprom
from heatwright.sim.native.hw import Hw, Log, Range
from heatwright.sim.native.master import callback
from heatwright.sim.native.one_wire import Line, Slave, Timing, attach, install
from heatwright.sim.native.parts import PARTS
from heatwright.sim.native.pins import Pins
from heatwright.sim.native.shim import load
from heatwright.sim.native.uart import Uarts

RAM_FILL = 0xC5
"""Contents of RAM at power-on: arbitrary in a real part; 0 would hide a missing initialisation."""

RESET_EVENT = np.dtype(
    {
        "names": ["cycle", "pc", "cause", "mcusr"],
        "formats": ["<u8", "<u4", "u1", "u1"],
        "itemsize": 16,
    }
)
"""A reset: cycle, program counter before it (flash byte), number in CAUSES, MCUSR after it."""

CAUSES = ("power_on", "external", "brown_out", "watchdog")


Core = Literal["own", "simavr"]
"""Which core runs the instructions: ours, or simavr's (Avr.use_simavrs_core)."""

_core: Core = "own"


@contextmanager
def instructions_by(core: Core) -> Iterator[None]:
    """Use this core for every processor that this process creates within the context."""
    global _core  # noqa: PLW0603 - code deep inside also creates processors, as at a loss of power
    earlier, _core = _core, core
    try:
        yield
    finally:
        _core = earlier


class AvrError(RuntimeError):
    """The program left its flash or RAM, or used what is not simulated; see the message."""


class Avr:
    """One processor, powered on when it is created; to cut its power, delete it.

    mcu -- a name in PARTS; clock_hz -- its crystal; supply_v -- its supply, also of AVCC and AREF;
    pins, uarts, adc, eeprom -- the peripherals that the outside sees. Raises ValueError: the part
    is not in PARTS; SimulatorMissing: there is no simulator.
    """

    def __init__(self, mcu: str, clock_hz: float, *, supply_v: float = 5.0) -> None:
        if mcu not in PARTS:
            raise ValueError(f"{mcu} is not simulated; {', '.join(PARTS)} are.")
        self.part = PARTS[mcu]
        self.clock_hz = round(clock_hz)
        hw = self._owner = self._power_on(mcu, supply_v)
        self._lib, self._ffi, self._hw = hw.lib, hw.ffi, hw.pointer
        self.pins = Pins(hw)
        self.uarts = Uarts(hw)
        self.adc = Adc(hw)
        self.adc.known(self.part.adc_known, self.part.known_mv)
        self.eeprom = Eeprom(hw, self.part.eeprom_write_s)
        self._reset_log = Log(hw, hw.lib.HW_RESET_LOG, RESET_EVENT)
        self._logs: list[Log] = [self.pins.log, self.uarts.log, self._reset_log]
        self._stack_bottom = self.part.ram_start
        self.write_ram(self.part.ram_start, bytes([RAM_FILL]) * self.ram_size)
        if _core == "simavr":
            self.use_simavrs_core()

    def _power_on(self, mcu: str, supply_v: float) -> Hw:
        shim = load()
        install(shim.ffi)
        spi.install(shim.ffi)
        callback(shim.ffi, "hw_pin_edge", lambda heard, low, cycle: heard(low, cycle))
        hw = shim.lib.hw_new(mcu.encode(), self.clock_hz, round(1000 * supply_v))
        part = self.part
        shim.lib.hw_sleep_register(hw, part.sleep_register, part.sleep_enable, part.sleep_mode)
        shim.lib.hw_adc_mux5(hw, part.adc_mux5)
        if part.old:
            shim.lib.hw_old_part(hw)
        return Hw(shim.lib, shim.ffi, shim.ffi.gc(hw, shim.lib.hw_free), self.clock_hz)

    def load(self, program: Elf) -> None:
        """Program the flash, and the EEPROM if the program has contents for it.

        Raises ValueError: the program is too large for the part.
        """
        room = self._lib.hw_flash_size(self._hw)
        if len(program.flash) > room:
            raise ValueError(f"The program has {len(program.flash)} bytes, the flash {room}.")
        self._ffi.buffer(self._lib.hw_flash(self._hw), room)[: len(program.flash)] = program.flash
        self._lib.hw_flash_changed(self._hw)
        if program.eeprom:
            self.eeprom.contents = program.eeprom
        self._stack_bottom = max(self.part.ram_start, program.static_ram[1])

    # -- time ----------------------------------------------------------------------------------

    @property
    def cycle(self) -> int:
        """Cycles since power-on."""
        cycle: int = self._lib.hw_cycle(self._hw)
        return cycle

    @property
    def time_s(self) -> float:
        """Time since power-on, s."""
        return self.cycle / self.clock_hz

    def run_to(self, cycle: int) -> None:
        """Run to a cycle: exactly when asleep, else to the end of the instruction that reaches it.

        Raises AvrError, whatever a chip on a bus has raised, and KeyboardInterrupt within
        a tenth of a second.
        """
        run, hw = self._lib.hw_run, self._hw
        while result := run(hw, cycle):
            self.came_back(result)
        self.raise_errors()

    def run_to_code(self, code: Function, cycle: int) -> bool:
        """Run until the next instruction is one of a function's, or to a cycle.

        Execute at least one; return whether the function is reached. Raises what run_to raises.
        """
        while result := self._lib.hw_run_to_code(self._hw, code.start, code.end, cycle):
            if result != self._lib.HW_NEWS:
                self.came_back(result)
            if code.start <= self.program_counter < code.end:
                break
        self.raise_errors()
        return bool(result)

    def run_looking(self, look: Look, cycle: int) -> bool:
        """Run to a cycle, or until `look` finds a message of the board; return whether it has.

        Raises what run_to raises.
        """
        asked = self._ffi.new("hw_look *", look)
        result = self._lib.hw_run_looking(self._hw, asked, NEVER, cycle)
        if result not in (0, self._lib.HW_NEWS):
            self.came_back(result)  # this empties the logs, so Python must do the next look
            self.run_to(min(asked.at, cycle))
            return bool(asked.at < cycle)
        self.raise_errors()
        return bool(result)

    def came_back(self, result: int) -> None:
        """Empty the logs after a run that returned early with one of the shim's results.

        Raises AvrError: it cannot go on.
        """
        if result != self._lib.HW_YIELD:
            raise AvrError(self._why())
        for log in self._logs:
            log.drain()

    def raise_errors(self) -> None:
        """Raise the oldest exception, if any, that a chip on a bus has raised."""
        if self._owner.errors:
            raise self._owner.errors.pop(0)

    @property
    def pointer(self) -> Any:
        """The processor's C pointer, for the shim's functions."""
        return self._hw

    def run(self, seconds: float) -> None:
        """Run for a time, s, from now on; see run_to."""
        self.run_to(self.cycle + round(seconds * self.clock_hz))

    def use_simavrs_core(self) -> None:
        """Use simavr's own core from now on: slower, and the reference for ours."""
        self._lib.hw_reference_core(self._hw, 1)

    def _why(self) -> str:
        text = self._ffi.string(self._lib.hw_message(self._hw)).decode(errors="replace")
        place = f"at flash byte 0x{self.program_counter:04x}, {self.time_s:.6f} s"
        return f"{text.strip() or 'The program has crashed'} ({place})."

    @property
    def sleep_cycles(self) -> int:
        """Cycles spent asleep."""
        return int(self._lib.hw_sleep_cycles(self._hw))

    @property
    def hung(self) -> bool:
        """Whether the processor sleeps with interrupts off: only a reset can wake it."""
        return bool(self._lib.hw_asleep_for_good(self._hw))

    # -- resets --------------------------------------------------------------------------------

    def reset(self, cause: Literal["external", "brown_out"] = "external") -> None:
        """Reset the processor now; RAM keeps its contents."""
        self._lib.hw_reset(self._hw, CAUSES.index(cause))

    def take_resets(self) -> NDArray[Any]:
        """Return the resets since the last call (RESET_EVENT records); power-on is not one."""
        return self._reset_log.take()

    # -- memory --------------------------------------------------------------------------------

    @property
    def ram_size(self) -> int:
        """Bytes of RAM, registers not counted."""
        return int(self._lib.hw_ram_end(self._hw)) + 1 - self.part.ram_start

    def read_ram(self, address: int, size: int) -> bytes:
        """Return bytes of the data space."""
        return bytes(self._memory()[address : address + size])

    def write_ram(self, address: int, data: bytes) -> None:
        """Set bytes of RAM; a register that is set in this way does not act."""
        self._memory()[address : address + len(data)] = data

    def flip(self, address: int, bit: int) -> None:
        """Flip a bit of the data space, as a particle would; a flipped register takes effect."""
        value = self.read_ram(address, 1)[0] ^ 1 << bit
        self._lib.hw_poke(self._hw, address, value)

    def read_flash(self, address: int, size: int) -> bytes:
        """Return bytes of the flash."""
        end = address + size
        return bytes(self._ffi.buffer(self._lib.hw_flash(self._hw), end)[address:end])

    def flip_flash(self, address: int, bit: int) -> None:
        """Flip a bit of the flash."""
        self.put_flash(address, self.read_flash(address, 1)[0] ^ 1 << bit)

    def put_flash(self, address: int, byte: int) -> None:
        """Set a byte of the flash."""
        self._ffi.buffer(self._lib.hw_flash(self._hw), address + 1)[address] = bytes([byte])
        self._lib.hw_flash_changed(self._hw)

    def jump(self, address: int) -> None:
        """Continue the program at this byte of the flash."""
        self._lib.hw_jump(self._hw, address)

    def _memory(self) -> Any:
        return self._ffi.buffer(self._lib.hw_ram(self._hw), self._lib.hw_ram_end(self._hw) + 1)

    @property
    def flags(self) -> int:
        """The status register."""
        return int(self._lib.hw_flags(self._hw))

    @property
    def program_counter(self) -> int:
        """Flash byte of the next instruction."""
        return int(self._lib.hw_program_counter(self._hw))

    @property
    def stack_used(self) -> int:
        """Bytes of stack the program has written so far (0 with no program loaded).

        Found by the fill value of RAM at power-on: a deepest byte that happens to have this value
        is missed. Profile.stack_used is exact.
        """
        top = int(self._lib.hw_ram_end(self._hw)) + 1
        above = self.read_ram(self._stack_bottom, top - self._stack_bottom)
        return len(above.lstrip(bytes([RAM_FILL])))

    # -- chips and recorders -------------------------------------------------------------------

    def one_wire(self, pin: str, slave: Slave, timing: Timing | None = None) -> Line:
        """Put a 1-Wire chip on a pin, with a pull-up resistor on the line."""
        self.pins.pull(pin, "high")
        number = self.pins.watch(pin, logged=False)
        return attach(self._owner, number, slave, timing or Timing())

    def spi(self, wires: spi.Wires, slave: spi.Slave, timing: spi.Timing | None = None) -> spi.Port:
        """Put an SPI chip on its wires."""
        names = wires.select, wires.clock, wires.data, wires.told
        pins = tuple(-1 if name is None else self.pins.watch(name, logged=False) for name in names)
        return spi.attach(self._owner, pins, slave, timing or spi.Timing())

    def snapshots(self, counter: Range, ram: Range, at: Function | None = None) -> Log:
        """Record a range of RAM each time the counter has changed at the start of a function.

        Without a function, as the processor goes to sleep. The records have the cycle and the image
        of the range. Raises ValueError outside RAM, beyond eight recorders, or for a second
        function.
        """
        where = self._lib.HW_AT_SLEEP if at is None else at.start
        number = self._lib.hw_snapshot(self._hw, *counter, *ram, where)
        if number < 0:
            raise ValueError("There are too many snapshots, or their range is not in RAM.")
        record = np.dtype([("cycle", "<u8"), ("image", "u1", (ram[1],))])
        self._logs.append(Log(self._owner, number, record))
        return self._logs[-1]

    def profile(self, program: Elf) -> Profile:
        """Profile the loaded program from now on."""
        found = Profile(self._owner, program)
        self._logs.append(found.log)
        return found
