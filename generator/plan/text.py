"""Text of the spec on its way into C comments and Markdown: it must not end either."""

from __future__ import annotations

import re

_MARKDOWN = re.compile(r"([\\`*_{}\[\]<>#|&~])")

_STRING = re.compile(r'(["\\]|(?<=\?)\?)')
"""What a C string literal must escape: its end, and the second character of a trigraph."""

_HOSTILE = re.compile(r"\*(?=/)|/(?=\*)|\?(?=\?)|-(?=-)")
"""The first character of what ends or begins a comment of C, a trigraph, or what XML's forbid."""


def ascii_units(text: str) -> str:
    """Text of ours with its units as comments have them."""
    return text.replace("°C", "degC")


def c_comment(text: str) -> str:
    """Text that cannot close a comment, open one, continue a line or form a trigraph.

    The same in HTML and XML, for a README and a panel begin with a comment too.
    """
    shown = "".join(character if character.isprintable() else "?" for character in text)
    return _HOSTILE.sub(r"\g<0> ", shown.replace("\\", "/"))


def c_string(text: str) -> str:
    """A C string literal of printable ASCII; any other character becomes `?`."""
    shown = "".join(each if " " <= each <= "~" else "?" for each in text)
    return '"' + _STRING.sub(r"\\\1", shown) + '"'


def markdown(text: str) -> str:
    """Text with every character that Markdown or HTML would act on escaped."""
    shown = "".join(character if character.isprintable() else "?" for character in text)
    return _MARKDOWN.sub(r"\\\1", shown)
