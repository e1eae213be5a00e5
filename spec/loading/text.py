"""Decodes the bytes of a file to text that is safe to parse and to show."""

import codecs
import re

from heatwright.spec.problems import Problem

LARGEST_FILE = 256 * 1024
"""Maximum number of bytes: 100 times a real spec, and few enough to be checked without a delay."""

_OTHER_ENCODINGS = (
    (codecs.BOM_UTF32_LE, "UTF-32"),
    (codecs.BOM_UTF32_BE, "UTF-32"),
    (codecs.BOM_UTF16_LE, "UTF-16"),
    (codecs.BOM_UTF16_BE, "UTF-16"),
)
_TAB = re.compile(r"^ *(\t)[ \t]*[^\s#]", re.MULTILINE)


class Unreadable(Exception):
    """The file cannot be read as a spec; nothing after the problem is reliable."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        self.problem = problem


def position(text: str, index: int) -> tuple[int, int]:
    """Return line and column, both from 1, of an index into the text."""
    return text.count("\n", 0, index) + 1, index - text.rfind("\n", 0, index)


def decode(data: bytes, file: str) -> str:
    """Decode and check a file; raises Unreadable at the first thing that is wrong."""
    if len(data) > LARGEST_FILE:
        raise _unreadable(
            file,
            "",
            f"the file has more than {LARGEST_FILE} bytes",
            "Check that this is the right file",
        )
    for mark, encoding in _OTHER_ENCODINGS:
        if data.startswith(mark):
            raise _unreadable(file, "", f"the file is written in {encoding}", "Save it as UTF-8")
    text = _utf8(data.removeprefix(codecs.BOM_UTF8), file)
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    for index, character in enumerate(text):
        if not (character.isprintable() or character in "\n\t"):
            _check_character(text, index, file)
    tab = _TAB.search(text)
    if tab:
        raise _unreadable(
            file, text[: tab.start(1)], "a tab indents this line", "Indent with blanks"
        )
    return text


def _utf8(data: bytes, file: str) -> str:
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        before = data[: error.start].decode()
        raise _unreadable(
            file,
            before.replace("\r\n", "\n"),
            f"the byte 0x{data[error.start]:02X} is not UTF-8",
            "Save the file as UTF-8",
        ) from None


def _check_character(text: str, index: int, file: str) -> None:
    character = text[index]
    if character.isspace() and ord(character) > 0x80 and character not in "\x85\u2028\u2029":
        return  # word processors put a blank of another width before a unit
    raise _unreadable(
        file,
        text[:index],
        f"the character U+{ord(character):04X} cannot be printed",
        "Delete it; it may be invisible in your editor",
    )


def _unreadable(file: str, before: str, reason: str, remedy: str) -> Unreadable:
    line, column = position(before, len(before))
    return Unreadable(Problem(file, line, column, "", reason, remedy))
