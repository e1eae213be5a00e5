"""Run a host build: one firmware, its world, and its state after each control step."""

from collections.abc import Mapping
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.host.build import HostBuild
from heatwright.sim.host.layout import declarations, state_type

INPUT = np.dtype(
    [
        ("reading_status", "u1"), ("acknowledge", "u1"), ("reading_raw", "i4"),
        ("setpoint_c", "f4"), ("command", "u1"), ("value", "f4"), ("gains", "f4", 3),
        ("current_status", "u1"), ("current_raw", "i2"), ("silent_ticks", "u2"),
        ("order", "u1"), ("argument", "u1"), ("open_inputs", "u1"),
        ("monitored", "u1"),
    ]
)  # fmt: skip
"""The inputs of one control step: `struct host_input`."""


READY = "ready"
"""Last member of the state of a loop that a host commands by its setpoint: the result of
`loop_X_is_ready` after the step."""
STATE = "state"
"""Last member of a switched loop's state: the result of `loop_X_state` after the step."""


class Command(IntEnum):
    """A host's command to a loop: `HOST_*` of world.h, which explains `value` and `gains`."""

    NOTHING = 0
    SET = 1
    MANUAL = 2
    TUNE = 3
    STOP_TUNING = 4
    GAINS = 5
    KEEP = 6
    RELOAD = 7
    DEFAULTS = 8
    EMERGENCY = 9
    ENABLE = 10
    DISABLE = 11
    PERCENT = 12
    AUTOMATIC = 13
    MAXIMUM = 14
    NUMBERS = 15
    LIMITS = 16


class HostHangs(RuntimeError):
    """An expected control step did not come."""


class Run(NamedTuple):
    """The results of a sequence of control steps."""

    states: NDArray[Any]
    """One row of states for each step, with the names of docs/control.md."""
    heater_counts: NDArray[np.uint32]
    """Ticks (timer counts, if a timer drives the pin) with the heater on, up to each step."""


class Host:
    """The host build of a firmware. Methods that name no loop act on the first loop.

    Raises HostHangs, in the methods that run steps: a step does not come.
    """

    def __init__(self, build: HostBuild) -> None:
        """Load the library and power up with an empty EEPROM."""
        self.build = build
        self._ffi = declarations(build.project, *build.loops)
        self.library = self._ffi.dlopen(str(build.library))
        self.types = {each.name: state_type(self._ffi, each) for each in build.loops}
        self.type = self.types[build.parts.name]
        self.world: Any = self.library.host_world()
        self.world.eeprom_bytes = build.controller.board.eeprom_bytes
        self._input = np.zeros(1, INPUT)
        self._input["setpoint_c"] = build.controller.loops[build.parts.name].setpoint.initial_c
        self.renew()

    def close(self) -> None:
        """Unload the library."""
        self._ffi.dlclose(self.library)

    def renew(self) -> None:
        """Power up with the EEPROM erased to its factory state."""
        self.eeprom[:] = b"\xff" * len(self.eeprom)
        self.power_up()

    @property
    def eeprom(self) -> Any:
        """The EEPROM's bytes, readable and writable."""
        return self._ffi.buffer(self.world.eeprom, self.world.eeprom_bytes)

    def power_up(self) -> None:
        """Reset all memory but the EEPROM, and start the firmware."""
        self.library.host_power_up()

    def set_reading(self, status: int, raw: int) -> None:
        """Set the status and the raw value of the sensor's readings from now on."""
        self._input["reading_status"], self._input["reading_raw"] = status, raw

    def set_setpoint(self, setpoint_c: float) -> None:
        """Set the setpoint from now on, °C."""
        self._input["setpoint_c"] = setpoint_c
        if self.build.parts.commanded:
            self.command(Command.SET, setpoint_c)

    def command(
        self, command: Command, value: float = 0.0, gains: tuple[float, ...] = (0.0, 0.0, 0.0)
    ) -> None:
        """Give the loop a command before its next step."""
        self._input["command"], self._input["value"], self._input["gains"] = command, value, gains

    def order(self, order: int, argument: int = 0) -> None:
        """Give the program a command before the next step: `program.order` of docs/control.md."""
        self._input["order"], self._input["argument"] = order, argument

    def acknowledge(self) -> None:
        """Acknowledge a fault before the next step."""
        self._input["acknowledge"] = 1

    def step(self) -> dict[str, Any]:
        """Run to the end of the next control step and return the state."""
        run = self.run(self._input)
        self._input["acknowledge"] = 0
        self._input["command"] = Command.NOTHING
        self._input["order"] = 0
        row = run.states[0]
        return {name: row[name] for name in self.type.names or ()}

    def run(self, inputs: NDArray[Any]) -> Run:
        """Run one control step for each of the inputs (of type INPUT)."""
        loop = self.build.parts.name
        return self.run_all({loop: inputs})[loop]

    def run_all(self, inputs: Mapping[str, NDArray[Any]]) -> dict[str, Run]:
        """Run one control step for each input of each loop, with all loops at the same time."""
        found, kept = {}, []
        courses = self._ffi.new("struct host_course[]", len(self.types))
        for course, (loop, kind) in zip(courses, self.types.items(), strict=True):
            rows = np.ascontiguousarray(inputs.get(loop, ()), INPUT)
            found[loop] = run = Run(np.zeros(len(rows), kind), np.zeros(len(rows), np.uint32))
            course.steps = len(rows)
            course.inputs = self._ffi.from_buffer("struct host_input[]", rows)
            course.states = self._ffi.from_buffer("uint8_t[]", run.states)
            course.counts = self._ffi.from_buffer("uint32_t[]", run.heater_counts)
            kept.append(rows)  # keeps them alive while the course points to them
        self.library.host_run(courses)
        for course, loop in zip(courses, found, strict=True):
            if course.done != course.steps:
                raise HostHangs(f"Step {course.done + 1} of {loop} did not come")
        return found

    def number(self, value: float, decimals: int) -> str:
        """Return the text that `text_number` writes for a value.

        Raises ValueError: it wrote outside its buffer, or returned a wrong length.
        """
        guard, size = 16, self.library.TEXT_SIZE
        memory = bytearray(b"\xa5" * (guard + size + guard))
        whole = self._ffi.from_buffer("char[]", memory, require_writable=True)
        length = self.library.text_number(whole + guard, value, decimals)
        text = bytes(memory[guard : guard + size])
        outside = bytes(memory[:guard] + memory[-guard:])
        if outside != b"\xa5" * (2 * guard) or text.find(0) != length:
            raise ValueError(f"text_number({value!r}, {decimals}) left {bytes(memory)!r}")
        return text[:length].decode("ascii")
