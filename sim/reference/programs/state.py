"""The state of the program that runs (docs/control.md, "Programs")."""

from dataclasses import dataclass
from operator import attrgetter

from heatwright.sim.reference.numbers import ZERO, Member, Single, Value

IDLE, RUNNING, PAUSED, RETURNING, RESTORING, INTERRUPTED = range(6)
"""States of a program."""
NOTHING, HELD_BACK, FOR_TARGET, FOR_OPERATOR = range(4)
"""Reasons why the program's clocks wait."""
FINISHED, STOPPED, FAILED, TOO_FAR, POWER_UNREADABLE = range(1, 6)
"""Reasons why a program ended."""
STOP, PAUSE, START, RESUME, SKIP, JUMP = 3, 5, 6, 9, 10, 12
"""Commands to a program."""
NO_ORDER = (0, 0)


@dataclass
class ProgramState:
    """Every member of the state, by its name."""

    state: int = IDLE
    waiting: int = NOTHING
    ended: int = 0
    number: int = 0
    segment: int = 0
    segments: int = 0
    order: int = 0
    argument: int = 0
    leap: int = 0
    kind: int = 0
    to_dc: int = 0
    amount: int = 0
    first_c: Single = ZERO
    from_c: Single = ZERO
    to_c: Single = ZERO
    setpoint_c: Single = ZERO
    before_c: Single = ZERO
    rate_k_per_s: Single = ZERO
    length: int = 0
    elapsed: int = 0
    waited: int = 0
    clock: int = 0
    segment_clock: int = 0
    energy: int = 0

    def values(self) -> tuple[Value, ...]:
        """Return the values of MEMBERS."""
        values: tuple[Value, ...] = _VALUES(self)
        return values


_WIDTHS = {
    "to_dc": "i2",
    "waited": "u2",
    **dict.fromkeys(("amount", "length", "elapsed", "clock", "segment_clock", "energy"), "u4"),
    **dict.fromkeys(("first_c", "from_c", "to_c", "setpoint_c", "before_c", "rate_k_per_s"), "f4"),
}
MEMBERS: tuple[Member, ...] = tuple(
    (name, _WIDTHS.get(name, "u1")) for name in ProgramState.__dataclass_fields__
)
_VALUES = attrgetter(*(name for name, _ in MEMBERS))
