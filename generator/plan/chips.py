"""Which chips write their registers otherwise than the rest do."""

from __future__ import annotations

from heatwright.spec.boards import Board

OLD = frozenset({"atmega16", "atmega32"})
"""Chips of the generation before the others. Their timers share TIMSK and TIFR, an 8-bit timer has
one control register (TCCR0) and one compare channel without letter (OCR0), UCSRC and UBRRH share an
address, and there is no DIDR (data sheets, "Register Summary")."""


def is_old(board: Board) -> bool:
    """Tell whether a board's chip is one of them."""
    return board.mcu in OLD
