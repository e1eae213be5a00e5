"""Ramp programs: the course of the setpoint over hours, and what happens after a power failure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from heatwright.spec.base import (
    DEFAULTS,
    MOST_ENTRIES,
    Model,
    Off,
    Reference,
    Temperature,
    WholeNumber,
)
from heatwright.spec.problems import Checked, refuse, shown
from heatwright.spec.quantity import Quantity, number
from heatwright.spec.units import DIFFERENCE, DURATION, PROGRAM_RATE

LONGEST_NAME = 12
"""Maximum length of a program's name: it fits beside its number on a display line of 16."""
MOST_POINTS = 20
LONGEST_SEGMENT_S = 31 * 86_400.0
FARTHEST_K = 100.0
"""Largest `resume_within`: a machine that has changed by more may have been opened meanwhile."""
FASTEST_K_PER_H = 6553.5
"""A rate is stored in steps of 0.1 K/h, in 16 bits."""

FAST = "as fast as possible"
UNTIL = "until operator"

SegmentKind = Literal["over", "rate", "fast", "hold", "until"]

_Time = Annotated[float, Quantity(DURATION, least=1.0, most=LONGEST_SEGMENT_S)]
_Band = Annotated[float, Quantity(DIFFERENCE, least=0.1)]


def _name(value: Any) -> str:
    plain = isinstance(value, str) and value.isascii() and value.isprintable()
    if not plain or not value.strip() or len(value) > LONGEST_NAME or set(value) & set('"\\'):
        raise refuse(
            f"a program's name has 1 to {LONGEST_NAME} plain characters, no quotation mark and "
            "no backslash",
            "Write, for example, fuse",
        )
    return str(value)


ProgramName = Annotated[
    str, Checked(_name, type="string", pattern=rf"^[ !#-\[\]-~]{{1,{LONGEST_NAME}}}$")
]


class Segment(Model):
    """One part of a program: a ramp to a temperature, or a hold."""

    to_c: Temperature | None = Field(None, alias="to", description="Target temperature.")
    over_s: _Time | None = Field(None, alias="over", description="Its duration, whole seconds.")
    asked_rate: (
        Annotated[
            float | str, Quantity(PROGRAM_RATE, least=0.1, most=FASTEST_K_PER_H, words=(FAST,))
        ]
        | None
    ) = Field(None, alias="at", description=f"Rate of the setpoint, or `{FAST}`.")
    asked_hold: (
        Annotated[
            float | str, Quantity(DURATION, least=1.0, most=LONGEST_SEGMENT_S, words=(UNTIL,))
        ]
        | None
    ) = Field(None, alias="hold", description=f"Time at the setpoint as it is, or `{UNTIL}`.")

    @model_validator(mode="after")
    def _one_form(self) -> Segment:
        ways = (self.over_s is not None) + (self.asked_rate is not None)
        if (self.asked_hold is None) == (self.to_c is None) or ways != (self.to_c is not None):
            raise refuse(
                "a segment either goes to a temperature or holds",
                "Write {to: 540 °C, over: 60 min}, {to: 540 °C, at: 150 K/h}, "
                f"{{to: 540 °C, at: {FAST}}}, {{hold: 30 min}} or {{hold: {UNTIL}}}",
            )
        for seconds in (self.over_s, self.hold_s):
            if seconds is not None and not seconds.is_integer():
                raise refuse(
                    f"{number(seconds)} s is no whole number of seconds", "Round it to seconds"
                )
        for tenths in (self.to_c, self.at_k_per_h):
            if tenths is not None and abs(tenths * 10 - round(tenths * 10)) > 1e-6:
                raise refuse(f"{number(tenths)} is stored in tenths", "Round it to one decimal")
        return self

    @property
    def kind(self) -> SegmentKind:
        """Which of the five kinds the segment has."""
        if self.until:
            return "until"
        if self.hold_s is not None:
            return "hold"
        if self.fast:
            return "fast"
        return "over" if self.over_s is not None else "rate"

    @property
    def fast(self) -> bool:
        """True if the setpoint jumps to the segment's end temperature."""
        return self.asked_rate == FAST

    @property
    def at_k_per_h(self) -> float | None:
        """Rate of the setpoint, K/h; None in all other kinds."""
        return self.asked_rate if isinstance(self.asked_rate, float) else None

    @property
    def until(self) -> bool:
        """True if the segment holds until the operator continues the program."""
        return self.asked_hold == UNTIL

    @property
    def hold_s(self) -> float | None:
        """Time of a hold, s; None in all other kinds."""
        return self.asked_hold if isinstance(self.asked_hold, float) else None


class Program(Model):
    """One program with its name, as the controller has it until an operator edits it."""

    name: ProgramName = Field(description=f"The program's name, up to {LONGEST_NAME} characters.")
    segments: tuple[Segment, ...] = Field(
        max_length=MOST_ENTRIES, description="The program's segments in order."
    )

    @model_validator(mode="after")
    def _something_to_do(self) -> Program:
        if not self.segments:
            raise refuse("a program of no segments does nothing", "Add one, such as {hold: 30 min}")
        return self


class HoldBack(Model):
    """The program's clock waits while the machine lags behind."""

    within_k: _Band = Field(
        8.0, alias="within", description="Deviation beyond which the program's clock waits."
    )
    limit_s: Annotated[float, Quantity(DURATION, least=1.0, most=65_535.0)] = Field(
        7200.0,
        alias="limit",
        description="Rule `program_lags`: longest total lag below in one segment.",
    )


class AfterPowerLoss(Model):
    """Whether a program resumes when power returns; the length of the outage is not known."""

    resume_within_k: Annotated[float, Quantity(DIFFERENCE, least=0.0, most=FARTHEST_K)] = Field(
        0.0,
        alias="resume_within",
        description="Largest change of temperature after which it resumes; 0 K: never.",
    )
    otherwise: Literal["stop", "pause"] = Field(
        "stop", description="What the program does after a larger change."
    )


def _within(value: Any) -> Any:
    """Read `10 K` as {within: 10 K}."""
    return value if isinstance(value, Mapping | HoldBack) or value is None else {"within": value}


Within = BeforeValidator(_within)
"""Marks a hold-back that may be written as its band alone."""


def _fits(value: Any) -> Any:
    if isinstance(value, str) and value == "stop":
        return {"resume_within": "0 K"}
    if not isinstance(value, Mapping | AfterPowerLoss):
        word = shown(value) if isinstance(value, str) else "this"
        raise refuse(
            f"{word} is not possible", "Write {resume_within: 30 K, otherwise: stop} or stop"
        )
    return value


Resumes = BeforeValidator(_fits)
"""Marks a field that may also be the word `stop`."""


class Programs(Model):
    """The programs of one loop, and how they run."""

    loop: Reference = Field(description="Loop whose setpoint the programs set.")
    points: Annotated[int, WholeNumber("a number of points", 1, MOST_POINTS, 10)] = Field(
        10, description="Maximum number of segments in one program."
    )
    asked_places: Annotated[int, WholeNumber("a number of programs", 1, 8, 4)] | None = Field(
        None,
        alias="places",
        description="How many programs the EEPROM keeps. Default: 3, or as many as are stored.",
    )
    hold_back: Annotated[HoldBack | None, Within, Off] = Field(
        DEFAULTS,
        validate_default=True,
        description="Lag beyond which the program's clock waits, or `off`.",
    )
    reached_within_k: _Band = Field(
        1.0,
        alias="reached_within",
        description="Deviation within which a target is reached, at a segment's end.",
    )
    after_power_loss: Annotated[AfterPowerLoss, Resumes] = Field(
        DEFAULTS, validate_default=True, description="What happens when the power comes back."
    )
    on_fault: Literal["stop", "pause"] = Field(
        "stop", description="What a fault does to a program: it ends, or may be resumed."
    )
    save_every_s: Annotated[float, Quantity(DURATION, least=10.0, most=3600.0)] = Field(
        60.0, alias="save_every", description="How often a running program saves its progress."
    )
    at_end: Literal["off", "hold"] = Field(
        "off", description="What the loop does after the last segment."
    )
    stored: tuple[Program, ...] = Field(
        (), max_length=8, description="Programs that are stored from the start."
    )

    @property
    def places(self) -> int:
        """Number of programs, including empty ones."""
        return self.asked_places or max(3, len(self.stored))
