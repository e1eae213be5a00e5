"""The G-code commands of the reference device (docs/control.md, "Commands")."""

import re
from collections.abc import Mapping
from typing import NamedTuple

from heatwright.sim.reference.interfaces.operator import Operator
from heatwright.sim.reference.modelled_loop import ModelledLoop
from heatwright.sim.reference.numbers import FULL, ZERO, Single
from heatwright.sim.reference.outputs.driven import Driven, Feed
from heatwright.sim.reference.protection.latch import Latch
from heatwright.spec import Controller, facts_of

_WORD = re.compile(r"([A-Z])(-?\d+\.?\d*|-?\.\d+)?")


class Line(NamedTuple):
    """A command and its words."""

    command: str
    """The command, such as `M104` or `T1`."""
    words: dict[str, float | None]
    """Number by letter; None: a letter without a number."""

    def number(self, letter: str) -> float | None:
        """Return the number after a letter; None if it is not there."""
        return self.words.get(letter)


def parsed(text: str) -> Line:
    """Parse a line; line number and checksum are ignored. Raises ValueError: it has no command."""
    plain = text.split(";", maxsplit=1)[0].split("*", maxsplit=1)[0].upper()
    words = [(letter, number) for letter, number in _WORD.findall(plain) if letter != "N"]
    if not words or words[0][0] not in "GMT" or not words[0][1]:
        raise ValueError(f"{text!r} has no command")
    (letter, code), *rest = words
    return Line(f"{letter}{int(float(code))}", {word: _value(number) for word, number in rest})


def _value(number: str) -> float | None:
    return float(number) if number else None


FAN_FULL = 255
"""The value that hosts send for a fan at full speed."""
HEAT = {"M104", "M140", "M141"}
WAIT = {"M109", "M190", "M191"}
GAINS = {"M301", "M304", "M309"}
OWN = {"M140": "B", "M190": "B", "M304": "B", "M141": "C", "M191": "C", "M309": "C"}
"""Commands for bed and chamber; the others are for a tool."""
TUNED = {-1: "B", -2: "C"}
"""The numbers of bed and chamber in M303."""
FEED_COMMANDS = {"G0", "G1", "G92", "M82", "M83", "M410"}


class Host:
    """A host that never waits, and gets no answers."""

    def __init__(
        self,
        controller: Controller,
        loops: Mapping[str, ModelledLoop],
        latch: Latch,
        driven: Mapping[str, Driven],
        feeds: Mapping[str, Feed],
    ) -> None:
        """Find the loops that the host commands."""
        gcode = facts_of(controller).gcode
        self._latch = latch
        served = gcode.loops if gcode else {}
        self._served = {address: loops[name].operator for address, name in served.items()}
        self._active = min((each for each in served if each.startswith("T")), default="")
        fans = gcode.fans if gcode else {}
        self._fans = {address: driven[name] for address, name in fans.items()}
        self._feeds = tuple(feeds[name] for name in gcode.steppers.values()) if gcode else ()

    def send(self, text: str) -> None:
        """Execute a line; a command that the firmware would refuse changes nothing.

        Raises ValueError: the controller has no host, or the line has no command.
        """
        if not self._served:
            raise ValueError("The specification has no gcode interface")
        line = parsed(text)
        if line.command in ("M106", "M107"):
            self._set_fan(line)
        elif line.command in FEED_COMMANDS:
            for feed in self._feeds:
                feed.command(line.command, line.number("E"), line.number("F"))
        elif line.command in self._served:
            self._active = line.command
        elif line.command == "M112":
            self._latch.stop()
        elif line.command == "M999":
            self._latch.acknowledge()
        elif line.command == "M108":
            for operator in self._served.values():
                operator.stop_tuning()
        else:
            self._order(line)

    def _set_fan(self, line: Line) -> None:
        number, speed = line.number("P"), line.number("S")
        addresses = [min(self._fans, default="")] if number is None else [f"P{int(number)}"]
        percent = FULL if speed is None else Single(speed) * FULL / Single(FAN_FULL)
        if line.command == "M107":
            addresses, percent = (list(self._fans) if number is None else addresses), ZERO
        for address in addresses:
            if address in self._fans:
                self._fans[address].set(min(percent, FULL))

    def _order(self, line: Line) -> None:
        operator = self._served.get(self._address(line))
        if operator is None:
            return
        if line.command in HEAT | WAIT:
            _heat(operator, line)
        elif line.command in GAINS:
            limits = (line.number("J"), line.number("K"), line.number("Y"))
            operator.set_gains(line.number("P"), line.number("I"), line.number("D"), limits=limits)
        elif line.command == "M303":
            cycles = line.number("C")
            operator.tune(line.number("S") or 0.0, None if cycles is None else int(cycles))

    def _address(self, line: Line) -> str:
        """Return the host's address of the loop: a tool as T or E, otherwise the active tool."""
        if line.command in OWN:
            return OWN[line.command]
        tunes = line.command == "M303"
        if tunes and "H" in line.words:
            heater = line.number("H")
            return "" if heater is None else f"T{int(heater) - 1}" if heater else "B"
        number = line.number("E") if line.number("T") is None else line.number("T")
        if number is None:
            return "" if tunes and "P" in line.words else self._active
        meant = TUNED.get(int(number)) if tunes else None
        return meant or f"T{int(number)}"


def _heat(operator: Operator, line: Line) -> None:
    waits = line.command in WAIT
    target_c = line.number("R" if waits and "R" in line.words else "S")
    if target_c is not None:
        operator.set(target_c)
    elif "D" in line.words and not waits:
        operator.set_manual(line.number("D"))
