"""Text of the spec on its way into C comments and Markdown: it must not end either."""

from __future__ import annotations

import re

_MARKDOWN = re.compile(r"([\\`*_{}\[\]<>#|&~])")


def c_comment(text: str) -> str:
    """Text that cannot close a comment, open one, continue a line or form a trigraph."""
    shown = "".join(character if character.isprintable() else "?" for character in text)
    for hostile in ("*/", "/*", "??"):
        shown = shown.replace(hostile, " ".join(hostile))
    return shown.replace("\\", "/")


def markdown(text: str) -> str:
    """Text with every character that Markdown or HTML would act on escaped."""
    shown = "".join(character if character.isprintable() else "?" for character in text)
    return _MARKDOWN.sub(r"\\\1", shown)
