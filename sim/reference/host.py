"""The G-code that the reference device understands (docs/control.md, "Commands")."""

from collections.abc import Mapping

from heatwright.sim.reference.driven import Driven
from heatwright.sim.reference.feed import Feed
from heatwright.sim.reference.line import Line, parsed
from heatwright.sim.reference.loop import Reference
from heatwright.sim.reference.numbers import FULL, ZERO, Single
from heatwright.sim.reference.operator import Operator
from heatwright.spec import Controller, gcode_of

FAN_FULL = 255
"""What hosts write for a fan at full speed."""
HEAT = {"B": ("M140", "M190"), "C": ("M141", "M191")}
GAINS = {"B": "M304", "C": "M309"}
TUNED = {"B": -1, "C": -2}
"""By what the host calls a loop; all that have another name are tools."""
FEED_COMMANDS = {"G0", "G1", "G92", "M82", "M83", "M410"}


class Host:
    """A host that never waits, and that nothing is answered."""

    def __init__(
        self,
        controller: Controller,
        operator: Operator,
        reference: Reference,
        driven: Mapping[str, Driven],
        feeds: Mapping[str, Feed],
    ) -> None:
        """Find what the host serves."""
        gcode = gcode_of(controller)
        (self._address,) = gcode.loops if gcode else ("",)
        self._served = gcode is not None
        self._operator = operator
        self._reference = reference
        fans = gcode.fans if gcode else {}
        self._fans = {address: driven[name] for address, name in fans.items()}
        self._feeds = tuple(feeds[name] for name in gcode.steppers.values()) if gcode else ()

    def send(self, text: str) -> None:
        """Do what a line asks for; what the firmware would refuse changes nothing.

        Raises:
            ValueError: no host is served, or the line has no command.

        """
        if not self._served:
            message = "The specification has no gcode interface"
            raise ValueError(message)
        line = parsed(text)
        if line.command in ("M106", "M107"):
            self._set_fan(line)
        elif line.command in FEED_COMMANDS:
            for feed in self._feeds:
                feed.command(line.command, line.number("E"), line.number("F"))
        else:
            self._order(line)

    def _set_fan(self, line: Line) -> None:
        fan = self._fans.get(f"P{int(line.number('P') or 0)}")
        if fan is None:
            return
        speed = line.number("S")
        percent = FULL if speed is None else Single(speed) * FULL / Single(FAN_FULL)
        fan.set(ZERO if line.command == "M107" else min(percent, FULL))

    def _order(self, line: Line) -> None:
        if line.command in HEAT.get(self._address, ("M104", "M109")):
            self._heat(line)
        elif line.command == GAINS.get(self._address, "M301"):
            self._operator.set_gains(line.number("P"), line.number("I"), line.number("D"))
        elif line.command == "M303" and self._is_tuned(line):
            cycles = line.number("C")
            target_c = line.number("S") or 0.0
            self._operator.tune(target_c, None if cycles is None else int(cycles))
        elif line.command == "M108":
            self._operator.stop_tuning()
        elif line.command == "M112":
            self._reference.stop()
        elif line.command == "M999":
            self._operator.acknowledge()

    def _is_tuned(self, line: Line) -> bool:
        """Whether the loop is meant: a tool by any number, for it is the only one."""
        named = line.number("E")
        return named == TUNED[self._address] if self._address in TUNED else named not in (-1, -2)

    def _heat(self, line: Line) -> None:
        waits = line.command in ("M109", "M190", "M191")
        target_c = line.number("R" if waits and "R" in line.words else "S")
        if target_c is not None:
            self._operator.set(target_c)
        elif "D" in line.words and not waits:
            self._operator.set_manual(line.number("D"))
