"""config.h of the chamber: every number from the data sheets and the spec, with its true source."""

import re
from collections.abc import Mapping
from pathlib import Path

import pytest
import yaml

from heatwright.generator import plan_firmware, render
from heatwright.spec import load

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"

CONSTANT = re.compile(r"^/\* (.+) \*/\n#define (\w+) (\S+[fu])$", re.MULTILINE)
WHERE = re.compile(r"\b\w+\.yaml:(\d+) ([a-z0-9_.\[\]]+)( \(default\))?")

# Worked out by hand from chamber.yaml and the data sheets of ATmega328P, DS18B20 and HD44780.
EXPECTED = {
    "CLOCK_COMPARE": 16_000_000 // 8 // 100 - 1,
    "CLOCK_TICKS_PER_SECOND": 100,
    "GATE_MAIN_PERMIT_TICKS": 10,
    "SENSOR_AIR_STEP_C": 1 / 16,
    "SENSOR_AIR_RAW_MASK": 0xFFFF,
    "SENSOR_AIR_SETTINGS": 0b0_11_11111,
    "SENSOR_AIR_CONVERSION_TICKS": 75,
    "SENSOR_AIR_START_TICKS": 100 - 75 - 5,
    "ONE_WIRE_AIR_COMPARE": 64 * 2 - 1,
    "ONE_WIRE_AIR_PRESENCE_COUNT": (64 - 61) * 2,
    "LOOP_AIR_PERIOD_TICKS": 100,
    "LOOP_AIR_SETPOINT_INITIAL_C": 20,
    "LOOP_AIR_SETPOINT_MINIMUM_C": 10,
    "LOOP_AIR_SETPOINT_MAXIMUM_C": 70,
    "LOOP_AIR_PERMIT_TICKS": 200,
    "LOOP_AIR_SENSOR_PERMIT_TICKS": 501,
    "LOOP_AIR_LEAD_S": 12,
    "LOOP_AIR_RATE_WEIGHT": 0.2,
    "LOOP_AIR_PER_PERIOD": 1,
    "LOOP_AIR_MAXIMUM_C": 85,
    "LOOP_AIR_MINIMUM_C": -10,
    "LOOP_AIR_RISE_PER_STEP_K": 5,
    "LOOP_AIR_STALE_STEPS": 5,
    "LOOP_AIR_RUNAWAY_ABOVE_K": 10,
    "LOOP_AIR_RUNAWAY_STEPS": 60,
    "LOOP_AIR_FULL_DUTY_PERCENT": 100,
    "LOOP_AIR_HEATING_RISE_K": 2,
    "LOOP_AIR_HEATING_STEPS": 120,
    "LOOP_AIR_FROZEN_STEPS": 600,
    "LOOP_AIR_OFF_RISE_K": 10,
    "LOOP_AIR_OFF_SETTLE_STEPS": 120,
    "LCD_POWER_UP_TICKS": 5,
    "LCD_RESYNC_TICKS": 3000,
    "PANEL_STEP_K": 10,
    "PANEL_SETPOINT_DECIMALS": 0,
    "SERIAL_DIVISOR": round(16_000_000 / 8 / 9600) - 1,
    "PLOTTER_DECIMALS": 2,
    "SETTINGS_SLOT_BYTES": 64,
    "SETTINGS_SLOTS": 16,
}


def test_every_constant_of_the_chamber(chamber_files: Mapping[str, str]) -> None:
    found = {}
    for _, name, text in CONSTANT.findall(chamber_files["src/config.h"]):
        whole = text.endswith("u")
        found[name] = int(text.removesuffix("u"), 0) if whole else float(text.removesuffix("f"))
        assert whole or text.endswith("f"), name
        assert whole == isinstance(EXPECTED.get(name), int) or name.endswith(
            ("_C", "_K", "_S", "_PERCENT", "_PERIOD", "_STEP_K")
        ), name
    assert found == EXPECTED
    defined = re.findall(r"^#define (\w+) ", chamber_files["src/config.h"], re.MULTILINE)
    assert defined == ["SPEC_DIGEST", *EXPECTED]


@pytest.mark.parametrize("name", [path.stem for path in sorted(EXAMPLES.glob("*.yaml"))])
def test_every_source_is_true(name: str) -> None:
    """A line named in the code holds the key; of a default, the nearest key above it."""
    spec = EXAMPLES / f"{name}.yaml"
    lines = spec.read_text("utf-8").splitlines()
    tree = yaml.compose("\n".join(lines))
    assert tree is not None
    files = render(plan_firmware(load(spec)))
    seen = 0
    for text in files.values():
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


def test_what_comes_from_the_spec_says_so(chamber_files: Mapping[str, str]) -> None:
    """Only what no key of the spec can change goes without a source."""
    without = {
        name
        for comment, name, _ in CONSTANT.findall(chamber_files["src/config.h"])
        if not WHERE.match(comment)  # at its beginning
    }
    assert without == {
        "CLOCK_COMPARE", "CLOCK_TICKS_PER_SECOND", "GATE_MAIN_PERMIT_TICKS", "SENSOR_AIR_STEP_C",
        "SENSOR_AIR_START_TICKS", "ONE_WIRE_AIR_COMPARE", "ONE_WIRE_AIR_PRESENCE_COUNT",
        "LCD_POWER_UP_TICKS", "LCD_RESYNC_TICKS", "PANEL_SETPOINT_DECIMALS", "PLOTTER_DECIMALS",
        "SETTINGS_SLOT_BYTES", "SETTINGS_SLOTS",
    }  # fmt: skip
