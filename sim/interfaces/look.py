"""How often a part that waits for the board's message looks for it.

A look without a message changes nothing. So C looks instead, and returns to Python when there is
a message (native/machine.c).
"""

from typing import NamedTuple


class Look(NamedTuple):
    """The times at which one part looks, in cycles.

    at -- the next look; every -- from one look to the next, or from the end of a look if it drifts;
    latest -- from here on it acts even without a message; uart, silence -- it waits until this UART
    has sent something and then been silent for so long; 0: it waits for anything from any UART.
    """

    at: int
    every: int
    latest: int
    drifts: bool = False
    uart: int = 0
    silence: int = 0


NEVER = 2**64 - 1
NO_LOOK = Look(NEVER, 0, NEVER)
