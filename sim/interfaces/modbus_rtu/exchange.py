"""One request of a Modbus master, and its answer."""

from dataclasses import dataclass

from heatwright.sim.interfaces.modbus_rtu.frames import Answer

TO_ALL = 0
"""The address of a broadcast, which no slave answers."""


@dataclass
class Exchange:
    """A request and its answer.

    address -- of the slave; pdu -- bytes of the request; writes -- the name of the written value,
    empty if it is no write by name; sends -- how often it may still be sent; sent_s -- end of its
    last bit; answer -- None until one comes, also None when `done` if there was none; delay_s --
    from the end of the silence after the request to the answer's first bit; polls -- whether it is
    one of the master's polls; again -- whether it is the second try, from off to on.
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
        """The exception's code; 0: none."""
        return self.answer.exception if self.answer else 0
