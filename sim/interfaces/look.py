"""How often somebody looks who waits for what the board sends.

Where nothing has come, to look changes nothing: C looks in his place, and says when there is
something (native/machine.c).
"""

from typing import NamedTuple


class Look(NamedTuple):
    """The looks of one; all in cycles.

    at -- the next one; every -- from one to the next, or from the end of one if it drifts; latest
    -- from here on he has something to do even if nothing has come; uart, silence -- he waits for
    what this UART sends until it has been silent for so long; 0: for anything of any.
    """

    at: int
    every: int
    latest: int
    drifts: bool = False
    uart: int = 0
    silence: int = 0


NEVER = 2**64 - 1
NO_LOOK = Look(NEVER, 0, NEVER)
