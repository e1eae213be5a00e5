"""Logs: no faster than the control, and no larger than the chip."""

from __future__ import annotations

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import SerialLog
from heatwright.spec.quantity import duration

RAM_ENTRY_BYTES = 4
"""Temperature and setpoint in tenths of a degree, 16 bits each."""

RAM_BESIDE_BYTES = 384
"""For the rest: variables and stack of the smallest firmware with a log take 327 bytes on an Uno.
`heatwright build` tells what a firmware really takes."""

RAM_OF_PROGRAMS_BYTES = 768
"""More of the same for programs, their menu and their sensor: 747 bytes in `kiln_uno.yaml`."""


def entries_are_new(controller: Controller) -> Findings:
    """Find logs that note each control step more than once."""
    for index, interface in enumerate(controller.interfaces):
        if not isinstance(interface, SerialLog) or interface.loop not in controller.loops:
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
    """Find logs whose entries come between two seconds: the log counts whole ones."""
    for index, interface in enumerate(controller.interfaces):
        if isinstance(interface, SerialLog) and not interface.every_s.is_integer():
            yield Finding(
                ("interfaces", index, "every"),
                f"{duration(interface.every_s)} is no whole number of seconds",
                f"Use {duration(round(interface.every_s))}",
            )


def entries_fit_ram(controller: Controller) -> Findings:
    """Find rings that leave no RAM for the rest."""
    board = controller.board
    beside = RAM_BESIDE_BYTES + RAM_OF_PROGRAMS_BYTES * (controller.programs is not None)
    most = max(board.ram_bytes - beside, 0) // RAM_ENTRY_BYTES
    for index, interface in enumerate(controller.interfaces):
        if not isinstance(interface, SerialLog) or interface.keep != "ram":
            continue
        if interface.entries > most:
            remedy = f"Use at most {most}, or keep: eeprom" if most else "Use keep: eeprom"
            yield Finding(
                ("interfaces", index, "entries"),
                f"{interface.entries} entries of {RAM_ENTRY_BYTES} bytes leave too little of the "
                f"{board.ram_bytes} bytes of RAM of the {board.mcu}",
                remedy,
                (("controller", "board"),),
            )
