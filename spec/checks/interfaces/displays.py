"""Displays and logs: at most one of each, menus for settings, intervals between entries."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.loops.timing import lasts_a_period
from heatwright.spec.checks.programs.programs import has_an_operator
from heatwright.spec.commands import gcode_of, nextion_of, placed
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import SerialLog
from heatwright.spec.quantity import duration

NO_MENU = "the loop has no nextion interface, and no lcd_keypad with programs"


def one_display(controller: Controller) -> Findings:
    """Find a second touch display, and a second log."""
    first: dict[str, int] = {}
    for index, interface in enumerate(controller.interfaces):
        if interface.line is None or not interface.line.can_move:
            continue  # ports.one_interface_per_port reports the others
        other = first.setdefault(interface.kind, index)
        if other != index:
            yield Finding(
                ("interfaces", index, "kind"),
                f"interfaces[{other}] is a {interface.kind} too, and only one is possible",
                "Delete one of them",
                (("interfaces", other),),
            )


def display_apart_from_host(controller: Controller) -> Findings:
    """Find a loop of a display that a host commands too, for which a setpoint of 0 means off."""
    display, gcode = nextion_of(controller), gcode_of(controller)
    if display is None or gcode is None or display.loop not in gcode.loops.values():
        return
    yield Finding(
        ("interfaces", controller.interfaces.index(display), "loop"),
        f"a gcode interface serves {display.loop} too: for a host a setpoint of 0 means off, for "
        "the display it is a temperature",
        "Keep one of them, or name another loop",
        (("interfaces", controller.interfaces.index(gcode)),),
    )


def maximum_has_an_operator(controller: Controller) -> Findings:
    """Find `maximum_adjustable` where no operator could lower the maximum."""
    for name, loop in controller.loops.items():
        if loop.protection.maximum_adjustable and not has_an_operator(controller, name):
            yield Finding(
                ("loops", name, "protection", "maximum_adjustable"),
                f"nobody could lower the maximum: {NO_MENU}",
                "Delete it",
                (("interfaces",), ("programs",)),
            )


def entries_are_new(controller: Controller) -> Findings:
    """Find logs that record each control step more than once."""
    for index, interface in placed(controller, SerialLog).items():
        if interface.loop not in controller.loops:
            continue
        name, loop = interface.loop, controller.loops[interface.loop]
        so, path = ", so entries would repeat themselves", ("interfaces", index, "every")
        yield from lasts_a_period(path, interface.every_s, name, loop, so)


def entries_have_a_time(controller: Controller) -> Findings:
    """Find logs whose interval is no whole number of seconds: a log counts whole seconds."""
    for index, interface in placed(controller, SerialLog).items():
        if not interface.every_s.is_integer():
            yield Finding(
                ("interfaces", index, "every"),
                f"{duration(interface.every_s)} is no whole number of seconds",
                f"Use {duration(round(interface.every_s))}",
            )
