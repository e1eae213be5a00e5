"""Common parts of all models: strict keys, frozen values, names, read-only maps."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict

from heatwright.spec.names import NAME, check_name
from heatwright.spec.problems import Checked, refuse, shown
from heatwright.spec.quantity import Quantity
from heatwright.spec.units import TEMPERATURE

DEFAULTS: Any = {}
"""Default of a field that holds a model: pydantic validates it, so the model's own defaults apply.
With an instance as the default, pydantic would build that model's validator during the import."""

MOST_ENTRIES = 100
"""Maximum number of entries of a mapping or list: the largest board has 86 pins."""

LONGEST_TITLE = 80
"""Maximum number of characters of a text for people, which must fit into one line of a comment."""

ABSOLUTE_ZERO_C = -273.15

K = TypeVar("K")
V = TypeVar("V")


class Model(BaseModel):
    """A part of the spec: unknown keys are refused, values never change."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", defer_build=True, hide_input_in_errors=True
    )


class Least(NamedTuple):
    """The least memory that a firmware needs: bytes of flash, and of RAM including the stack."""

    flash: int
    ram: int


class ReadOnlyDict(dict[K, V]):
    """A dict that nothing can change, in the order of the file."""

    def _refuse(self, *_: object, **__: object) -> Any:
        raise TypeError("a spec is read-only")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[type[ReadOnlyDict[K, V]], tuple[dict[K, V]]]:
        return type(self), (dict(self),)

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(tuple(self.items()))


def _plain_text(value: object) -> str:
    """Accept text for people: one line of printable characters, 1 to 80 of them."""
    if not isinstance(value, str):
        raise refuse("text is needed here", "Put it between quotation marks")
    if not value.strip():
        raise refuse("this text is empty", "Write a few words, or delete the key")
    if len(value) > LONGEST_TITLE:
        raise refuse(f"this text has {len(value)} characters", f"Use at most {LONGEST_TITLE}")
    if not value.isprintable():
        raise refuse(
            "this text has a line break or another unprintable character", "Retype it on one line"
        )
    return value


def _name(value: object) -> str:
    if not isinstance(value, str):
        raise refuse("a name is needed here", "Write lower-case letters, digits and _")
    check_name(value)
    return value


def _reference(value: object) -> str:
    if not isinstance(value, str):
        raise refuse("the name of something defined in this file is needed", "Write its name")
    return value


def _frozen(value: Mapping[K, V]) -> Mapping[K, V]:
    return ReadOnlyDict(value)


def _not_more(value: Mapping[K, V], most: int) -> Mapping[K, V]:
    if len(value) > most:
        raise refuse(f"{len(value)} are defined here", f"Define at most {most}")
    return ReadOnlyDict(value)


def _filled(value: Mapping[K, V]) -> Mapping[K, V]:
    if not value:
        raise refuse("nothing is defined here", "Define at least one")
    return _not_more(value, MOST_ENTRIES)


def at_most(most: int) -> AfterValidator:
    """Return the validator of a mapping that may have at most `most` entries."""
    return AfterValidator(lambda value: _not_more(value, most))


def off_is_none(value: object) -> object:
    """Read the word `off` as None."""
    return None if value == "off" else value


Off = BeforeValidator(off_is_none)
Name = Annotated[str, Checked(_name, type="string", pattern=NAME)]
Reference = Annotated[str, Checked(_reference, type="string")]
Title = Annotated[
    str,
    Checked(
        _plain_text,
        type="string",
        minLength=1,
        maxLength=LONGEST_TITLE,
        pattern=r"^(?=.*\S)[^\u0000-\u001f\u007f-\u009f\u2028\u2029]*$",
    ),
]
Temperature = Annotated[float, Quantity(TEMPERATURE, least=ABSOLUTE_ZERO_C)]
ReadOnly = AfterValidator(_frozen)
Filled = AfterValidator(_filled)
"""Marks a mapping that must have at least one entry, and at most MOST_ENTRIES."""

PIN = r"^([AD][0-9]{1,2}|P[A-L][0-7])$"
_PIN = re.compile(PIN)


def _pin(value: object) -> str:
    if not isinstance(value, str) or not _PIN.fullmatch(value):
        raise refuse(
            f"{shown(value)} is not a pin" if isinstance(value, str) else "a pin is needed here",
            "Name it as on the board (D3, A0) or by its port (PB3)",
        )
    return value


PIN_MARK = Checked(_pin, type="string", pattern=PIN, examples=["D3", "A0", "PB3"])
PinName = Annotated[str, PIN_MARK]


class WholeNumber(Checked):
    """Marks a whole number with bounds: `Annotated[int, WholeNumber("a count", 1, 32, 4)]`."""

    def __init__(self, what: str, least: int, most: int, example: int) -> None:
        """Set the bounds; `what` names the number in messages."""
        super().__init__(self.read_number, type="integer", minimum=least, maximum=most)
        self._what, self._least, self._most, self._example = what, least, most, example

    def read_number(self, value: object) -> int:
        """Accept a whole number within the bounds."""
        whole = isinstance(value, int) and not isinstance(value, bool)
        if not whole or not self._least <= value <= self._most:  # type: ignore[operator]
            raise refuse(
                f"{self._what} must be a whole number from {self._least} to {self._most}",
                f"Write, for example, {self._example}",
            )
        return value  # type: ignore[return-value]


class BareNumber(Checked):
    """Marks a number without a unit: above `least` (from `least` if `closed`), up to `most`."""

    def __init__(self, least: float, most: float, example: str, *, closed: bool = False) -> None:
        """Set the bounds."""
        lower = {"minimum" if closed else "exclusiveMinimum": least}
        super().__init__(self.read_number, type="number", maximum=most, **lower)
        self._least, self._most, self._example, self._closed = least, most, example, closed

    def read_number(self, value: object) -> float:
        """Accept a number within the bounds."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise refuse(
                "a bare number is needed here", f"Write it without a unit, such as {self._example}"
            )
        if not self._least <= value <= self._most or (value == self._least and not self._closed):
            word = "from" if self._closed else "above"
            raise refuse(
                f"{value} is not possible",
                f"Use a number {word} {self._least:g}, up to {self._most:g}",
            )
        return float(value)
