"""What is no part of the language yet, or is found elsewhere: refused, with these words."""

from __future__ import annotations

KINDS: dict[str, str] = {}
"""Kinds by the union they will join."""

KEYS: dict[str, str] = {}
"""Keys by the model they will join."""

ELSEWHERE = {("Analog", "quantity"): "Use kind: current for the current of a heater"}
"""Keys that somebody may look for in a model, and what does it in their place."""

NOT_BUILT = "is a planned part of the language that is not built yet"


def kind(union: str, word: str) -> bool:
    """Tell whether `word` will be a kind of `union`."""
    return word in KINDS.get(union, "").split()


def key(model: str, word: str) -> bool:
    """Tell whether `word` will be a key of `model`."""
    return word in KEYS.get(model, "").split()
