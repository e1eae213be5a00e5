"""Commands to a program in a scenario: `program: start 1`, `program: pause`."""

from typing import Annotated, Any, Literal, NamedTuple, get_args

from heatwright.spec.problems import Checked, refuse, shown

Order = Literal["start", "pause", "resume", "skip", "jump", "stop"]
NUMBERED = ("start", "jump")
"""The commands with a number: of a program, or of a segment."""


class ProgramOrder(NamedTuple):
    """One command; its number counts from 1, and is 0 if the command has none."""

    order: Order
    number: int = 0


def _order(value: Any) -> ProgramOrder:
    if isinstance(value, ProgramOrder):
        return value  # already converted
    words = value.split() if isinstance(value, str) else []
    order = words[0] if words else ""
    rest = words[1:]
    numbered = order in NUMBERED
    fits = len(rest) == numbered and all(word.isascii() and word.isdigit() for word in rest)
    if order not in get_args(Order) or not fits or any(not 1 <= int(word) <= 99 for word in rest):
        word = f"{shown(value)} is" if isinstance(value, str) else "this is"
        raise refuse(
            f"{word} no command to a program", "Write start 1, pause, resume, skip, jump 3 or stop"
        )
    return ProgramOrder(order, int(rest[0]) if rest else 0)  # type: ignore[arg-type]


ProgramOrders = Annotated[
    ProgramOrder,
    Checked(_order, type="string", pattern=r"^((start|jump) [1-9][0-9]?|pause|resume|skip|stop)$"),
]
