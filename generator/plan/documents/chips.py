"""What the builder of a bare chip sets before the program runs."""

from __future__ import annotations

from typing import NamedTuple

from heatwright.spec.boards import Board


class Fuses(NamedTuple):
    """What the builder of a bare chip has to set before it keeps time and notices a low supply."""

    clock: str
    brown_out: str
    brown_out_v: str
    """Brown-out level for a supply of 5 V (data sheets, "Fuse Bits", "BODLEVEL Fuse Coding")."""
    has_wdton: bool
    """Whether a fuse can leave the watchdog on for good."""


def fuses(board: Board) -> Fuses | None:
    """Name the fuses of a bare chip; boards come with theirs set."""
    if board.name != board.mcu:
        return None
    if board.is_old:
        return Fuses("CKSEL, SUT and CKOPT", "BODEN and BODLEVEL", "4.0", has_wdton=False)
    return Fuses("CKSEL, SUT and CKDIV8", "BODLEVEL", "4.3", has_wdton=True)
