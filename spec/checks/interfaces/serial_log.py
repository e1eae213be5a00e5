"""Logs: intervals between entries."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.loops.timing import lasts_a_period
from heatwright.spec.commands import placed
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import SerialLog
from heatwright.spec.quantity import duration


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
