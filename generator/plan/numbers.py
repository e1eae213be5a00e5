"""Numbers for C: literals that keep every bit, counts, and quantities for comments."""

from decimal import Decimal

from heatwright.spec import Loop
from heatwright.spec.sensing.conversion import float32

TICK_MS = 10
"""Length of the firmware's tick, ms. Every period and time-out is a whole number of ticks."""


def c_float(value: float) -> str:
    """Return the shortest C literal of type float that is exactly float32(value)."""
    rounded = float32(value)
    for digits in range(1, 10):
        text = f"{rounded:.{digits}g}"
        if _is_exact(text, rounded):
            break
    if 1e-6 < abs(rounded) < 1e9:
        text = format(Decimal(text), "f")
    return f"{text}f" if "." in text or "e" in text else f"{text}.0f"


def _is_exact(text: str, rounded: float) -> bool:
    try:
        return float32(float(text)) == rounded
    except OverflowError:  # rounded up beyond the largest float
        return False


def c_count(value: int) -> str:
    """A C literal of an unsigned count."""
    return f"{value}u"


def milliseconds(duration_s: float) -> int:
    """Return whole milliseconds; the spec refuses durations with fractions of them."""
    return round(duration_s * 1000)


def ticks(duration_s: float) -> int:
    """Whole ticks in `duration_s`, rounded down: a limit comes early rather than late."""
    return milliseconds(duration_s) // TICK_MS


def steps(duration_s: float, loop: Loop) -> int:
    """Whole control periods in `duration_s`, rounded down, at least one."""
    return max(1, milliseconds(duration_s) // milliseconds(loop.period_s))


def filter_share(filter_s: float, loop: Loop) -> float:
    """Share of the newest value in a first-order low pass: period / (time constant + period)."""
    return loop.period_s / (filter_s + loop.period_s)


def quantity(value: float, unit: str) -> str:
    """A number and its unit for a comment, such as `0.5 K/s`; ASCII only."""
    return f"{value:g} {unit}"


def told_period(loop: Loop) -> str:
    """The control period for a comment, such as `0.5 s`."""
    return quantity(loop.period_s, "s")


def in_periods(duration_s: float, loop: Loop) -> str:
    """The derivation of a number of `steps`, for a comment: `60 s in periods of 0.5 s`."""
    return f"{quantity(duration_s, 's')} in periods of {told_period(loop)}"
