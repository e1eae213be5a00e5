"""Checks of the scenario: events in order of time, interfaces and programs that take them."""

from heatwright.spec.checks.finding import Finding, Findings, scenario_events, untaken
from heatwright.spec.commands import keypad_of
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path
from heatwright.spec.programs import Programs
from heatwright.spec.quantity import duration
from heatwright.spec.scenario.program_orders import ProgramOrder


def comparison_has_plant(controller: Controller) -> Findings:
    """Find comparisons without a machine to compare on."""
    if controller.comparison and controller.simulation is None:
        reason = "a comparison needs a simulated machine"
        yield Finding(("comparison",), reason, "Add a section simulation")


def scenario_in_order(controller: Controller) -> Findings:
    """Find scenarios without an end, and events out of order or after the end."""
    if controller.simulation is None:
        return
    events = controller.simulation.scenario
    path: Path = ("simulation", "scenario")
    ends = [index for index, event in enumerate(events) if event.for_s is not None]
    if ends != [len(events) - 1]:
        where = (*path, ends[0]) if ends else path
        yield Finding(
            where,
            "exactly one event, the last, must end the scenario",
            "Put {for: 30 min} last, and only there",
        )
        return
    length_s = events[-1].for_s or 0.0
    before_s = 0.0
    for index, event in enumerate(events[:-1]):
        at_s = event.at_s or 0.0
        if at_s < before_s:
            yield Finding(
                (*path, index, "at"),
                f"{duration(at_s)} is before the event above it, at {duration(before_s)}",
                "Write the events in the order of time",
            )
        elif at_s >= length_s:
            yield Finding(
                (*path, index, "at"),
                f"{duration(at_s)} is not before the end of the scenario, at {duration(length_s)}",
                "Lengthen `for`, or make the event earlier",
            )
        before_s = max(before_s, at_s)


def extrusion_takes_heat(controller: Controller) -> Findings:
    """Find events that feed filament where the plant has no `filament`."""
    if controller.simulation is not None and controller.simulation.plant.filament is None:
        yield from untaken(
            controller,
            "extrude",
            "extrude_mm_per_s",
            "the plant does not say from which node filament takes heat",
            "Add filament: {node: …, heat: 0.0056 J/K/mm} to the plant, or delete the event",
            ("simulation", "plant"),
        )


def keys_exist(controller: Controller) -> Findings:
    """Find presses of keys on a controller without a keypad."""
    if keypad_of(controller) is None:
        remedy = "Add {kind: lcd_keypad, loop: …} to interfaces, or delete the event"
        reason = "no interface has keys"
        yield from untaken(controller, "press", "press", reason, remedy, ("interfaces",))


_PROGRAMS: tuple[Path, ...] = (("programs",),)


def orders_have_programs(controller: Controller) -> Findings:
    """Find commands to programs and expectations of ramps where there are no programs."""
    if controller.simulation is None or controller.programs is not None:
        return
    reason, remedy = "there are no programs", "Add a section programs, or delete the event"
    yield from untaken(controller, "program", "program", reason, remedy, ("programs",))
    expect = controller.simulation.expect
    if expect is not None and expect.tracking_k is not None:
        yield Finding(
            ("simulation", "expect", "tracking"),
            "there are no programs, and so no ramps",
            "Delete it",
            _PROGRAMS,
        )


def orders_find_their_place(controller: Controller) -> Findings:
    """Find commands that start an empty program, or jump to a segment that no program has."""
    programs = controller.programs
    if programs is None:
        return
    edited = False
    for path, event in scenario_events(controller):
        edited = edited or event.send is not None
        if event.program is not None:
            yield from _place((*path, "program"), event.program, programs, edited)


def _startable(filled: int) -> str:
    if filled == 0:
        return "Store a program, and write start 1"
    return "Write start 1" if filled == 1 else f"Write start with a number from 1 to {filled}"


def _place(path: Path, asked: ProgramOrder, programs: Programs, edited: bool) -> Findings:
    """Check one command; a line sent to the display before it may have stored a program."""
    filled = programs.places if edited else len(programs.stored)
    if asked.order == "start" and asked.number > filled:
        there = f"places is {programs.places}" if edited else f"stored has {filled}"
        yield Finding(
            path, f"program {asked.number} is empty: {there}", _startable(filled), _PROGRAMS
        )
    elif asked.order == "jump" and asked.number > programs.points:
        yield Finding(
            path,
            f"there is no segment {asked.number}: a program has at most {programs.points}",
            f"Write jump with a number from 1 to {programs.points}",
            _PROGRAMS,
        )
