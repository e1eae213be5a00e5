"""The fuses that the builder of a bare chip must set before the program runs."""

from typing import NamedTuple

from heatwright.spec.boards import Board


class Fuses(NamedTuple):
    """The fuses of a bare chip for the right clock, and for detecting a low supply."""

    clock: str
    brown_out: str
    brown_out_v: str
    """Brown-out level for a supply of 5 V (data sheets, "Fuse Bits", "BODLEVEL Fuse Coding")."""
    has_wdton: bool
    """True if a fuse can switch the watchdog on permanently."""


def fuses(board: Board) -> Fuses | None:
    """Name the fuses of a bare chip; those of boards are set already."""
    if board.name != board.mcu:
        return None
    if board.is_old:
        return Fuses("CKSEL, SUT and CKOPT", "BODEN and BODLEVEL", "4.0", has_wdton=False)
    return Fuses("CKSEL, SUT and CKDIV8", "BODLEVEL", "4.3", has_wdton=True)
