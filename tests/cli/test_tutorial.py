"""The tutorial: each command in it is run, in its order, and prints what stands there."""

import re
import shlex
import subprocess

import pytest
from rig.commands import Heatwright
from rig.firmware import ROOT

from heatwright.cli.main import COMMANDS

DOCS = ROOT / "docs"
TEXT = (DOCS / "tutorial.md").read_text(encoding="utf-8")
CONSOLES = "".join(re.findall(r"```console\n(.*?)```", TEXT, re.DOTALL))
STEPS = re.findall(r"^\$ (.*)\n((?:[^$].*\n)*)", CONSOLES, re.MULTILINE)
"""Command, and what it prints."""


def pattern(printed: str) -> str:
    """Make a line of … match any lines, and … within a line anything there."""
    lines = printed.splitlines(keepends=True)
    return "".join(
        "(?:.*\n)*" if line == "…\n" else re.escape(line).replace("…", ".+") for line in lines
    )


@pytest.mark.parametrize(
    ("found", "fits"),
    [
        ("a\nb 1 c\n", True),
        ("a\nx\ny\nb 2 c\n", True),
        ("a\nb 2\n", False),
        ("a\nb 2\n c\n", False),
    ],
)
def test_what_is_left_out_may_be_anything(found: str, fits: bool) -> None:
    assert bool(re.fullmatch(pattern("a\n…\nb … c\n"), found)) == fits


def test_each_command_prints_what_stands_there(heatwright: Heatwright) -> None:
    assert len(STEPS) > 5
    for command, printed in STEPS:
        program, _, words = command.partition(" ")
        if program == "heatwright":
            found = heatwright(words, status=2 * (":43:7:" in printed)).out
        else:
            found = subprocess.check_output(shlex.split(command), text=True)
        assert re.fullmatch(pattern(printed), found), command


def test_it_names_commands_and_pictures_that_there_are() -> None:
    assert set(re.findall(r"(?:`|\$ |    )heatwright ([a-z]+) ", TEXT)) <= {*COMMANDS, "bench"}
    pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", TEXT)
    assert len(pictures) >= 3
    assert [each for each in pictures if not (DOCS / each).is_file()] == []
