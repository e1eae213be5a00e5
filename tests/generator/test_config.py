"""What a number or a block of the generated C says of where it comes from is true."""

import re

import pytest
import yaml
from rig.specs import EXAMPLES, files_of

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
