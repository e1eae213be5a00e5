"""The bytes that the touch display's pages send for a command to the program."""

from collections.abc import Mapping

from heatwright.spec.scenario.program_orders import Order

COMMANDS: Mapping[Order, str] = {
    "start": "#8 {number};",
    "pause": "#9 0;",
    "resume": "#9 1;",
    "skip": "#18;",
    "jump": "#10 {number};",
    "stop": "#17;",
}


def in_bytes(order: Order, number: int) -> str:
    """Return the command; number -- of a program or a segment, for those that have one.

    "Go here" goes to the segment after the one that it names.
    """
    return COMMANDS[order].format(number=number - (order == "jump"))
