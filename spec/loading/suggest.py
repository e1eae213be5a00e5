"""Suggestions for a wrong word, and for keys that belong elsewhere in the language."""

from collections.abc import Sequence

from heatwright.spec.problems import refuse

_LONGEST_WORD = 40


def closest(word: str, known: Sequence[str]) -> str | None:
    """Find the known word that `word` was probably meant to be."""
    from difflib import get_close_matches  # noqa: PLC0415  (only a wrong spec needs the time of this import)

    if len(word) > _LONGEST_WORD:
        return None
    found = get_close_matches(word.lower(), [name.lower() for name in known], n=1)
    return next((name for name in known if found and name.lower() == found[0]), None)


def listed(words: Sequence[str]) -> str:
    """Write words as a choice: `a, b or c`."""
    *others, last = words
    return f"{', '.join(others)} or {last}" if others else last


def advice(word: str, known: Sequence[str]) -> str:
    """Suggest the word that was probably meant, or list all known words."""
    match = closest(word, known)
    if match is not None:
        return f"Did you mean {match}?"
    return f"Use {listed(known)}"


def one_of(value: object, what: str, known: Sequence[str]) -> Exception:
    """Make the error for a word that is not in `known`."""
    word = value if isinstance(value, str) else ""
    shown = repr(word) if 0 < len(word) <= _LONGEST_WORD else "this"
    return refuse(f"{shown} is not a {what}", advice(word, known))


ELSEWHERE = {
    ("Analog", "quantity"): "Use kind: current for the current of a heater",
    (
        "TimeProportionalOutput",
        "current",
    ): "Only the kinds digital and pwm have it: change kind, or delete current",
    ("Event", "setpoint"): "Use write: {LOOP.setpoint: 50 °C}, which needs an interface modbus_rtu",
    ("Segment", "rate"): "Write at:, as in {to: 540 °C, at: 150 K/h}",
}
"""Keys that a user may try in a model, with the keys to write instead."""

NOT_BUILT = "is a planned part of the language that is not built yet"
