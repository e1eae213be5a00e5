"""Escapes text of the spec for C comments and Markdown, so that it cannot end them."""

import re

_MARKDOWN = re.compile(r"([\\`*_{}\[\]<>#|&~])")

_STRING = re.compile(r'(["\\]|(?<=\?)\?)')
"""Characters to escape in a C string literal: its end, and the second one of a trigraph."""

_HOSTILE = re.compile(r"\*(?=/)|/(?=\*)|\?(?=\?)|-(?=-)")
"""First character of a C comment's begin or end, a trigraph, or `--` (forbidden in XML)."""


def ascii_units(text: str) -> str:
    """Replace units by their ASCII form, for comments."""
    return text.replace("°C", "degC")


def c_comment(text: str) -> str:
    """Make text that cannot close a comment, open one, continue a line or form a trigraph.

    Also in HTML and XML, because a README and a panel begin with a comment.
    """
    shown = "".join(character if character.isprintable() else "?" for character in text)
    return _HOSTILE.sub(r"\g<0> ", shown.replace("\\", "/"))


def c_string(text: str) -> str:
    """Make a C string literal of printable ASCII; any other character becomes `?`."""
    shown = "".join(each if " " <= each <= "~" else "?" for each in text)
    return '"' + _STRING.sub(r"\\\1", shown) + '"'


def markdown(text: str) -> str:
    """Escape every character that has a meaning in Markdown or HTML."""
    shown = "".join(character if character.isprintable() else "?" for character in text)
    return _MARKDOWN.sub(r"\\\1", shown)


def derivation_words(derivation: str | None) -> str:
    """Return how a number was derived, for the end of its comment; "" if it was given."""
    return f", derived from the plant: {ascii_units(derivation)}" if derivation else ""
