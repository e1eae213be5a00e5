"""Logs: no faster than the control, in whole seconds."""

from __future__ import annotations

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.commands import placed
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import SerialLog
from heatwright.spec.quantity import duration


def entries_are_new(controller: Controller) -> Findings:
    """Find logs that note each control step more than once."""
    for index, interface in placed(controller, SerialLog).items():
        if interface.loop not in controller.loops:
            continue
        period_s = controller.loops[interface.loop].period_s
        if interface.every_s < period_s:
            yield Finding(
                ("interfaces", index, "every"),
                f"{duration(interface.every_s)} is shorter than the period of "
                f"{duration(period_s)}, so entries would repeat themselves",
                f"Use at least {duration(period_s)}",
                (("loops", interface.loop, "period"),),
            )


def entries_have_a_time(controller: Controller) -> Findings:
    """Find logs whose interval is no whole number of seconds: a log counts whole seconds."""
    for index, interface in placed(controller, SerialLog).items():
        if not interface.every_s.is_integer():
            yield Finding(
                ("interfaces", index, "every"),
                f"{duration(interface.every_s)} is no whole number of seconds",
                f"Use {duration(round(interface.every_s))}",
            )
