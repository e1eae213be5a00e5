"""What docs/evidence.md quotes from commands is what the commands print; its tables are held, too.
A quotation is an indented block: a line with `$ ` and the command, below it lines that it prints,
in their order. Blanks and rules of tables do not count. What holds a figure is a key of a spec,
whose value it is; a line of a quotation, which has its numbers; or, where ours has no number, a
test. Else it is not built."""

import os
import re
import shlex
import sys
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml
from rig.firmware import ROOT, finished

from heatwright.cli.ends import ended
from heatwright.cli.main import cli

PAGE = (ROOT / "docs" / "evidence.md").read_text(encoding="utf-8")
EXAMPLES = ROOT / "spec" / "examples"
MACHINES = ("oven", "kiln", "chamber", "feeder", "fabricator", "extruder")
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
        told = finished(
            [sys.executable, *words], env={**os.environ, "COLUMNS": "120"}, check=True
        ).stdout
    return bare(told)


FIGURES = "| figure | published | ours | residual | held by |"
LINES = "| machine | what | shown by |"


def rows(heading: str) -> list[list[str]]:
    """Return the cells of all tables with these headings."""
    tables = re.findall(rf"^{re.escape(heading)}\n.*\n((?:\|.*\n)+)", PAGE, re.MULTILINE)
    lines = [line for table in tables for line in table.splitlines()]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def numbers(text: str) -> list[str]:
    return re.findall(r"(?<![\w.])[+-]?\d+(?:\.\d+)?", text)


def value_at(place: str) -> Any:
    """Return what stands in an example, as "kiln.yaml: loops.chamber.period" says it."""
    file, path = place.split(": ")
    found: Any = yaml.safe_load((EXAMPLES / file).read_text(encoding="utf-8"))
    for key in path.split("."):
        found = found[int(key) if isinstance(found, list) else key]
    return found


def assert_is_a_test(name: str) -> None:
    file, *_, function = name.split("::")
    text = (ROOT / file).read_text(encoding="utf-8")
    assert re.search(rf"^ *def {function}\(", text, re.MULTILINE), name


def assert_holds(by: str, ours: str) -> None:
    if by.startswith("not built: "):
        assert ours == "–"
        return
    assert by[0] == by[-1] == "`", by
    by = by.strip("`")
    if by.startswith("tests/"):
        assert not numbers(ours), "a test holds no number to what is printed"
        assert_is_a_test(by)
    elif by.startswith("$ "):
        command, label = by.removeprefix("$ ").split(": ", maxsplit=1)
        found = [
            line.removeprefix(label)
            for quotation in quotations(PAGE)
            if set(command.split()) <= {Path(word).name for word in quotation.command.split()}
            for line in quotation.lines
            if line.startswith(label)
        ]
        assert len(found) == 1, by
        assert set(numbers(ours)) <= set(numbers(found[0])), by
    else:
        assert ours == str(value_at(by)), by


@pytest.mark.parametrize("row", rows(FIGURES), ids=lambda row: row[0])
def test_each_published_figure_is_held_and_its_residual_is_the_difference(row):
    _, published, ours, residual, by = row
    assert_holds(by, ours)
    theirs, own, less = numbers(published), numbers(ours), numbers(residual)
    if not less:
        assert published == ours or len(theirs) != len(own) or unit(published) != unit(ours)
        return
    for one, other, rest in zip(theirs, own, less, strict=True):
        digits = len((rest if "." in rest else one).partition(".")[2])
        assert float(rest) == round(float(other) - float(one), digits)


def unit(text: str) -> str:
    return re.sub(r"[\d. ]", "", text)


@pytest.mark.parametrize("row", rows(LINES), ids=lambda row: row[1])
def test_each_line_is_shown_by_a_test(row):
    machine, _, by = row
    assert machine in {*MACHINES, "hotend", "all"}
    assert_is_a_test(by.strip("`"))


def test_every_machine_has_lines_and_figures():
    """The hotend is the extruder of its file."""
    shown = {machine.replace("hotend", "extruder") for machine, *_ in rows(LINES)}
    held = {found for *_, by in rows(FIGURES) for found in re.findall(r"(\w+)\.yaml", by)}
    assert set(MACHINES) <= shown
    assert set(MACHINES) <= held


@pytest.mark.parametrize("quotation", quotations(PAGE), ids=lambda each: each.command)
def test_what_the_page_quotes_is_printed(quotation, capfd, monkeypatch):
    monkeypatch.chdir(ROOT)
    told = iter(printed(quotation.command, capfd))
    for line in quotation.lines:
        assert line in told, line


@pytest.mark.parametrize("machine", MACHINES)
def test_each_machine_has_its_figures_on_the_page(machine):
    assert any(f"{machine}.yaml" in quotation.command for quotation in quotations(PAGE))
