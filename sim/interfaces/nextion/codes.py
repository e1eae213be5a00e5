"""Answers of a Nextion display to instructions (Nextion Instruction Set, section 7)."""

from enum import IntEnum

END = b"\xff\xff\xff"
"""Ends an instruction to the display, and each of its answers."""
STARTED = b"\0\0\0" + END
READY = b"\x88" + END
"""The display sends both when it has started."""
LONGEST_NAME = 14
"""Maximum number of characters in the name of a page or a component."""


class Code(IntEnum):
    """First byte of an answer."""

    INVALID_INSTRUCTION = 0x00
    DONE = 0x01
    INVALID_COMPONENT = 0x02
    INVALID_PAGE = 0x03
    INVALID_BAUD = 0x11
    INVALID_WAVEFORM = 0x12
    INVALID_VARIABLE = 0x1A
    INVALID_OPERATION = 0x1B
    INVALID_QUANTITY = 0x1E
    INVALID_ESCAPE = 0x20
    NAME_TOO_LONG = 0x23
    BUFFER_OVERFLOW = 0x24
    TOUCHED = 0x65
    PAGE = 0x66
    TEXT = 0x70
    NUMBER = 0x71

    def answer(self, data: bytes = b"") -> bytes:
        """Return the answer that begins with this code."""
        return bytes([self]) + data + END


class Refused(ValueError):
    """An instruction that the display cannot execute; code -- its answer."""

    def __init__(self, code: Code) -> None:
        super().__init__(code.name.lower().replace("_", " "))
        self.code = code
