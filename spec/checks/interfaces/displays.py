"""Displays and logs: at most one of each, menus for settings."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.programs.programs import has_an_operator
from heatwright.spec.commands import gcode_of, nextion_of
from heatwright.spec.controller import Controller

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
