"""One request of a Modbus master, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass

from heatwright.sim.interfaces.modbus_rtu.frames import Answer

TO_ALL = 0
"""The address of a broadcast, which nobody answers."""


@dataclass
class Exchange:
    """A request, and what came of it.

    address, pdu -- what is asked of whom; writes -- the name of what it writes, empty if it is not
    for a user; sends -- how often it may still be sent; sent_s -- when its last bit had left;
    answer -- None while there is none, and for ever once `done`; delay_s -- from the end of the
    silence after the request to the answer's first bit; polls -- whether the master has asked by
    itself; again -- whether this is the second try, by a change from off to on.
    """

    address: int
    pdu: bytes
    writes: str = ""
    sends: int = 1
    polls: bool = False
    again: bool = False
    sent_s: float | None = None
    answer: Answer | None = None
    delay_s: float | None = None
    done: bool = False

    @property
    def refusal(self) -> int:
        """The exception's code, 0 for none."""
        return self.answer.exception if self.answer else 0
