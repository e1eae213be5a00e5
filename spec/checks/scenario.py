"""Checks of the scenario: events in order of time, and interfaces that can receive them."""

from heatwright.spec.checks.finding import Finding, Findings, untaken
from heatwright.spec.commands import keypad_of
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path
from heatwright.spec.quantity import duration


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
