"""Commands of a scenario to programs, and its expectations of their ramps."""

from heatwright.spec.checks.finding import Finding, Findings, scenario_events, untaken
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path
from heatwright.spec.programs import Programs
from heatwright.spec.scenario.program_orders import ProgramOrder

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
            path,
            f"program {asked.number} is empty: {there}",
            _startable(filled),
            _PROGRAMS,
        )
    elif asked.order == "jump" and asked.number > programs.points:
        yield Finding(
            path,
            f"there is no segment {asked.number}: a program has at most {programs.points}",
            f"Write jump with a number from 1 to {programs.points}",
            _PROGRAMS,
        )
