"""Numbers of the generated C: exact, early rather than late, and from where they say."""

import math
import re
import struct
from fractions import Fraction

import numpy as np
import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st
from rig.specs import EXAMPLES, files_of

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


CONSTANT = re.compile(r"^/\* (.+) \*/\n#define (\w+) (\S+[fu])$", re.MULTILINE)
WHERE = re.compile(r"\b\w+\.yaml:(\d+) ([a-z0-9_.\[\]]+)( \(default\))?")


@pytest.mark.parametrize("name", [path.stem for path in sorted(EXAMPLES.glob("*.yaml"))])
def test_every_source_is_true(name: str) -> None:
    """A line named in the code holds the key; of a default, the nearest key above it."""
    lines = (EXAMPLES / f"{name}.yaml").read_text("utf-8").splitlines()
    tree = yaml.compose("\n".join(lines))
    assert tree is not None
    seen = 0
    for text in files_of(name).values():
        for number, keys, default in WHERE.findall(text):
            path = [int(key) if key.isdigit() else key for key in re.findall(r"\w+", keys)]
            depth, line = nearest(tree, path)
            assert int(number) == line, keys
            assert bool(default) == (depth < len(path)), keys
            key = path[depth - 1] if depth else 0
            assert isinstance(key, int) or f"{key}:" in lines[line - 1], keys
            seen += 1
    assert seen > 40


def nearest(node: yaml.Node, path: list[str | int]) -> tuple[int, int]:
    """Return how far a path leads into the tree, and the line of its last key that is there."""
    depth, line = 0, 1
    for step in path:
        if isinstance(node, yaml.MappingNode):
            entries = {key.value: (key, value) for key, value in node.value}
            if step not in entries:
                break
            key, node = entries[step]
            line = key.start_mark.line + 1
        elif isinstance(node, yaml.SequenceNode) and isinstance(step, int):
            node = node.value[step]
            line = node.start_mark.line + 1
        else:
            break
        depth += 1
    return depth, line


def test_what_comes_from_the_spec_says_so() -> None:
    """Only what no key of the spec can change goes without a source."""
    constants = CONSTANT.findall(files_of("chamber")["src/config.h"])
    assert {name for comment, name, _ in constants if not WHERE.match(comment)} == {
        "CLOCK_COMPARE", "CLOCK_TICKS_PER_SECOND", "GATE_MAIN_PERMIT_TICKS", "SENSOR_AIR_STEP_C",
        "SENSOR_AIR_START_TICKS", "ONE_WIRE_AIR_COMPARE", "ONE_WIRE_AIR_PRESENCE_COUNT",
        "LCD_POWER_UP_TICKS", "LCD_RESYNC_TICKS", "PANEL_SETPOINT_DECIMALS", "PLOTTER_DECIMALS",
        "SETTINGS_SLOT_BYTES", "SETTINGS_SLOTS",
    }  # fmt: skip
