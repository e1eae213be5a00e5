"""What docs/evidence.md quotes from commands is what the commands print.

A quotation is an indented block: a line with `$ ` and the command, below it lines that it prints,
in their order. Blanks and rules of tables do not count.
"""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from heatwright.cli.ends import ended
from heatwright.cli.main import cli

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "evidence.md").read_text(encoding="utf-8")
MACHINES = ("oven", "kiln", "chamber", "feeder", "fabricator")
"""The machines whose published figures the page compares with ours."""


RULES = str.maketrans(dict.fromkeys("│┃━─┏┳┓┡╇┩└┴┘", " "))


class Quotation(NamedTuple):
    command: str
    lines: list[str]


def quotations(page: str) -> list[Quotation]:
    found = []
    for block in re.findall(r"(?:^    .*\n)+", page, re.MULTILINE):
        for command, lines in re.findall(
            r"^    \$ (.*)\n((?:    (?!\$ ).*\n)*)", block, re.MULTILINE
        ):
            found.append(Quotation(command, bare(lines)))
    return found


def bare(text: str) -> list[str]:
    """Return the lines that say something, with one blank between words."""
    lines = (" ".join(line.translate(RULES).split()) for line in text.splitlines())
    return [line for line in lines if line]


def printed(command: str, capfd: pytest.CaptureFixture[str]) -> list[str]:
    program, *words = shlex.split(command)
    if program == "heatwright":
        capfd.readouterr()
        assert ended(cli, words) == 0
        told = capfd.readouterr().out
    else:
        assert program == "python"
        told = subprocess.run(
            [sys.executable, *words],
            check=True,
            capture_output=True,
            text=True,
            env={**os.environ, "COLUMNS": "120"},
        ).stdout
    return bare(told)


@pytest.mark.parametrize("quotation", quotations(PAGE), ids=lambda each: each.command)
def test_what_the_page_quotes_is_printed(quotation, capfd, monkeypatch):
    monkeypatch.chdir(ROOT)
    told = iter(printed(quotation.command, capfd))
    for line in quotation.lines:
        assert line in told, line


@pytest.mark.parametrize("machine", MACHINES)
def test_each_machine_has_its_figures_on_the_page(machine):
    assert any(f"{machine}.yaml" in quotation.command for quotation in quotations(PAGE))
