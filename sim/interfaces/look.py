"""How often a part that waits for a message of the board looks for it.

A look that finds no message changes nothing. So C looks in place of the part, and returns to Python
only when there is a message (native/machine.c).
"""

from typing import NamedTuple


class Look(NamedTuple):
    """The times at which one part looks, in cycles.

    at -- the next look; every -- from one look to the next, or from the end of a look if it drifts;
    latest -- from here on it acts even without a message; uart, silence -- it waits until this UART
    has sent something and was then silent for this time; 0: it waits for anything from any UART.
    """

    at: int
    every: int
    latest: int
    drifts: bool = False
    uart: int = 0
    silence: int = 0


NEVER = 2**64 - 1
NO_LOOK = Look(NEVER, 0, NEVER)
