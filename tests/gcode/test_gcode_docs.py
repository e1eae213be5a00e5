"""docs/gcode.md tells of every command of the firmware, and of none that there is not."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
TABLE = re.compile(r"^\| (`[^|]+`[^|]*)\|", re.MULTILINE)


def in_the_firmware() -> set[str]:
    text = (ROOT / "templates" / "interfaces" / "gcode.c.j2").read_text("utf-8")
    functions = {"G": ("do_g",), "M": ("do_m", "do_gains", "do_feed")}
    found = set()
    for letter, names in functions.items():
        for name in names:
            body = text.partition(f"static bool {name}(void)\n")[2].partition("\n}\n")[0]
            found |= {f"{letter}{number}" for number in re.findall(r"case (\d+):", body)}
    return found


def test_every_command_is_told_and_no_other() -> None:
    page = (ROOT / "docs" / "gcode.md").read_text("utf-8")
    table = page.partition("## Commands")[2].partition("\n`G0` to")[0]
    told = {command for row in TABLE.findall(table) for command in re.findall(r"\b[GM]\d+\b", row)}
    assert told == in_the_firmware()
