"""Which chips write their registers otherwise than the rest do."""

from __future__ import annotations

from typing import NamedTuple

from heatwright.spec.boards import Board

OLD = frozenset({"atmega16", "atmega32"})
"""Chips of the generation before the others. Their timers share TIMSK and TIFR, an 8-bit timer has
one control register (TCCR0) and one compare channel without letter (OCR0), UCSRC and UBRRH share an
address, and there is no DIDR (data sheets, "Register Summary")."""


def is_old(board: Board) -> bool:
    """Tell whether a board's chip is one of them."""
    return board.mcu in OLD


class Fuses(NamedTuple):
    """What the builder of a bare chip has to set before it keeps time and notices a low supply."""

    clock: str
    brown_out: str
    brown_out_v: str
    """Of the levels for 5 V (data sheets, "Fuse Bits", "BODLEVEL Fuse Coding")."""
    has_wdton: bool
    """Whether a fuse can leave the watchdog on for good."""


def fuses(board: Board) -> Fuses | None:
    """Name the fuses of a bare chip; boards come with theirs set."""
    if board.name != board.mcu:
        return None
    if is_old(board):
        return Fuses("CKSEL, SUT and CKOPT", "BODEN and BODLEVEL", "4.0", has_wdton=False)
    return Fuses("CKSEL, SUT and CKDIV8", "BODLEVEL", "4.3", has_wdton=True)
