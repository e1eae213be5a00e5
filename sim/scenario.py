"""The events of a scenario: actions of operator, host, display, master and machine."""

import re
from collections.abc import Iterable
from typing import NamedTuple, Protocol

from heatwright.sim.coupling import Coupling
from heatwright.spec import RULES, Controller, Event, ProgramOrder, Simulation, Write, facts_of
from heatwright.spec.scenario.program_orders import Order
from heatwright.spec.simulation import LEAST_VERIFIED_S

PRESS_S = 0.1
"""A short press: the key is down for this time, then up for at least as long."""

ASKS = Event.model_validate({"at": "1 s", "send": "M105"})
"""The line by which a host requests the temperatures as soon as the controller has started."""

STOP = re.compile(r"\s*(N\d+\s*)?M112(?!\d)", re.IGNORECASE)
"""A host's line with an emergency stop, which latches a fault."""

DISTURBING = {"G0", "G1", "M106", "M107"}
"""Commands that change the machine's loss of heat."""


class Operable(Protocol):
    """A controller as its operator, host, display and master see it."""

    def press(self, key: str | None) -> None:
        """Hold a key of the keypad from now on: right, up, down, left, select; None for none."""

    def send(self, line: str) -> None:
        """Send a line of G-code as the host, or a command as the display."""

    def write(self, name: str, value: float | bool) -> None:
        """Write a value as the master, by its name in a scenario."""

    def program(self, order: Order, number: int = 0) -> None:
        """Give the program a command: start or jump with a number, pause and so on."""


class Action(NamedTuple):
    """One action: a line, write or command is sent, the feed changes, or a key goes down or up."""

    time_s: float
    key: str | None = None
    """The key that is held from now on; None in a key's action: no key."""
    line: str | None = None
    """The line of the host or the display."""
    extrude_mm_per_s: float | None = None
    """The speed at which filament is fed from now on."""
    write: Write | None = None
    """The master's write."""
    program: ProgramOrder | None = None
    """The command to a program."""

    def give(self, device: Operable, coupling: Coupling) -> None:
        """Do the action, without waiting for its effect."""
        if self.line is not None:
            device.send(self.line)
        elif self.write is not None:
            device.write(*self.write)
        elif self.program is not None:
            device.program(*self.program)
        elif self.extrude_mm_per_s is not None:
            coupling.extruded_mm_per_s = self.extrude_mm_per_s
        else:
            device.press(self.key)

    @property
    def disturbs(self) -> bool:
        """Return whether the action disturbs the machine: a feed, a fan."""
        command = (self.line or "").split(" ", maxsplit=1)[0].upper()
        return self.extrude_mm_per_s is not None or command in DISTURBING

    @property
    def text(self) -> str | None:
        """The text for a plot's legend; None for the release of a key."""
        if self.extrude_mm_per_s is not None:
            return f"extrude {self.extrude_mm_per_s:g} mm/s"
        if self.write is not None:
            return f"{self.write.name} = {_shown(self.write.value)}"
        if self.program is not None:
            return f"{self.program.order} {self.program.number or ''}".rstrip()
        return self.line or self.key


def long_enough(controller: Controller) -> Controller:
    """Lengthen a short scenario; a host that sends nothing in it then polls temperatures once.

    A real host polls; without polls the firmware would treat it as lost in the additional time.
    """
    simulation = controller.simulated
    if not any(map(_is_short, simulation.scenario)):
        return controller
    scenario = tuple(
        event.model_copy(update={"for_s": LEAST_VERIFIED_S}) if _is_short(event) else event
        for event in simulation.scenario
    )
    if facts_of(controller).gcode is not None and not any(event.send for event in scenario):
        scenario = (ASKS, *scenario)
    longer = simulation.model_copy(update={"scenario": scenario})
    return controller.model_copy(update={"simulation": longer})


def _is_short(event: Event) -> bool:
    return event.for_s is not None and event.for_s < LEAST_VERIFIED_S


def stops(simulation: Simulation) -> bool:
    """Return whether a scenario sends an emergency stop."""
    return any(STOP.match(event.send) for event in simulation.scenario if event.send is not None)


def unasked(
    simulation: Simulation, tripped: Iterable[tuple[float, int]]
) -> list[tuple[float, int]]:
    """Return the faults (time in s, code) that the scenario does not cause on purpose."""
    asked = stops(simulation)
    return [each for each in tripped if not (asked and RULES[each[1]].id == "emergency_stop")]


def actions(scenario: Iterable[Event]) -> tuple[Action, ...]:
    """Return all actions of a scenario, in order of time.

    Each press is 100 ms down, or as long as it says, and 100 ms up. A press whose time comes during
    the press before waits for its end.
    """
    found: list[Action] = []
    free_s = 0.0
    for event in sorted((e for e in scenario if e.for_s is None), key=_begin_s):
        start_s = _begin_s(event)
        if event.press is not None:
            start_s = max(start_s, free_s)
            found += _presses(event, start_s)
            free_s = found[-1].time_s + PRESS_S
        elif event.write is not None:
            found += [Action(start_s, write=write) for write in event.write]
        else:
            found.append(
                Action(
                    start_s,
                    line=event.send,
                    extrude_mm_per_s=event.extrude_mm_per_s,
                    program=event.program,
                )
            )
    return tuple(sorted(found, key=lambda action: action.time_s))


def end_s(scenario: Iterable[Event]) -> float:
    """Return the time at which a scenario ends: its `for`. Raises ValueError: it has none."""
    for event in scenario:
        if event.for_s is not None:
            return event.for_s
    raise ValueError("A scenario needs its end: - {for: 30 min}")


def _presses(event: Event, start_s: float) -> list[Action]:
    found: list[Action] = []
    held_s = event.held_s or PRESS_S
    for number in range(event.times):
        down_s = start_s + number * (held_s + PRESS_S)
        found += [Action(down_s, event.press), Action(down_s + held_s)]
    return found


def _shown(value: float | bool) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}"


def _begin_s(event: Event) -> float:
    return event.at_s or 0.0
