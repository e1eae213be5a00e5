"""Readings of each loop that a G-code host commands, from the reports to M105."""

import re
from collections.abc import Iterator

from heatwright.cli.plot.hearing import Hearing, Read, Reading
from heatwright.spec import Controller, Gcode, facts_of

FULL = 127.0
"""Full duty in a report."""
EVERY_S = 1.0

_NUMBER = r"-?\d{1,6}(?:\.\d{1,6})?"
_END = r"(?!\S)"
"""Pattern of the characters after a number, so that a damaged `201..3` is not read."""


def hearings(controller: Controller, interface: Gcode) -> Iterator[Hearing]:
    """Yield the way to read each loop that the interface serves."""
    del controller
    for address, loop in interface.loops.items():
        read = _reported(address, [*interface.loops])
        yield Hearing(loop, interface.kind, interface.line, read, b"M105\n", EVERY_S)


def labels_of(controller: Controller, name: str) -> tuple[str, str] | None:
    """Return the labels of a loop in the reports to its G-code host; None if it has no host."""
    interface = facts_of(controller).gcode
    served = {} if interface is None else interface.loops
    found = (_labels(address, [*served]) for address, loop in served.items() if loop == name)
    return next(found, None)


def _labels(address: str, served: list[str]) -> tuple[str, str]:
    """Return the labels of a loop's temperature and duty in a report."""
    if not address.startswith("T"):
        return address, f"{address}@"
    several = sum(each.startswith("T") for each in served) > 1
    return (address, f"@{address[1:]}") if several else ("T", "@")


def _reported(address: str, served: list[str]) -> Read:
    """Read a printer's report: `ok T:201.3 /200.0 B:60.1 /60.0 @:76 B@:31`."""
    title, duty = _labels(address, served)
    found_c = re.compile(rf"(?:^|\s){title}:({_NUMBER}) ?/({_NUMBER}){_END}")
    found_duty = re.compile(rf"(?:^|\s){duty}:(\d{{1,6}}){_END}")

    def read(line: str, time_s: float) -> Iterator[Reading]:
        temperatures, share = found_c.search(line), found_duty.search(line)
        if temperatures is not None and share is not None:
            percent = 100 * int(share[1]) / FULL
            yield Reading(time_s, float(temperatures[1]), float(temperatures[2]), percent)

    return read
