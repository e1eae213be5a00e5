"""Numbers reach C with every bit, and whole: literals, counts, steps."""

import math
import re
import struct
from fractions import Fraction

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from heatwright.generator.plan.numbers import c_float, float32, milliseconds, steps, ticks

PATTERNS = st.integers(0, 2**32 - 1)
LITERAL = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]\d\d)?f")


def of_bits(pattern: int) -> float:
    return float(struct.unpack("<f", struct.pack("<I", pattern))[0])


def bits(value: float) -> int:
    return int(np.float32(value).view(np.uint32))


@given(PATTERNS)
@example(0x00000000)
@example(0x80000000)
@example(0x00000001)
@example(0x007FFFFF)
@example(0x7F7FFFFF)
@example(0x4B800000)
@example(bits(0.0625))
def test_a_literal_names_its_value_and_no_other(pattern: int) -> None:
    value = of_bits(pattern)
    if not math.isfinite(value):
        return
    literal = c_float(value)
    assert LITERAL.fullmatch(literal), literal
    assert "." in literal or "e" in literal, literal
    text = literal.removesuffix("f")
    assert bits(float(text)) == pattern
    # As a compiler reads it, at once: nearest to this value, whatever double would make of it.
    exact = Fraction(text)
    with np.errstate(over="ignore"):
        others = np.nextafter(np.float32(value), np.array([-np.inf, np.inf], np.float32))
    for other in map(float, others):
        if math.isfinite(other):
            assert abs(exact - Fraction(value)) <= abs(exact - Fraction(other))


@given(st.floats(-1e6, 1e6))
def test_a_double_is_rounded_once(value: float) -> None:
    assert bits(float(c_float(value).removesuffix("f"))) == bits(value)
    assert float32(value) == float(np.float32(value))


@given(st.integers(1, 600_000), st.integers(1, 6000))
def test_a_limit_comes_early_rather_than_late(duration_ms: int, period_ticks: int) -> None:
    period_ms = 10 * period_ticks
    duration_s, period_s = duration_ms / 1000, period_ms / 1000
    assert milliseconds(duration_s) == duration_ms
    assert ticks(duration_s) == duration_ms // 10
    count = steps(duration_s, period_s)
    assert count == max(1, duration_ms // period_ms)
    assert count == 1 or count * period_ms <= duration_ms < (count + 1) * period_ms
