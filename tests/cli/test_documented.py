"""What the tutorial and `docs/ci.md` have users do does there what it says.

Each command of the tutorial is run, in its order, and prints what stands there.
"""

import os
import re
import shlex
import subprocess
import sysconfig
from pathlib import Path
from typing import Any

import pytest
import yaml
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


HOOK, WORKFLOW = (
    yaml.safe_load(text)
    for text in re.findall(r"```yaml\n(.*?)```", (ROOT / "docs" / "ci.md").read_text("utf-8"), re.S)
)
JOB_STEPS: list[dict[str, Any]] = WORKFLOW["jobs"]["verify"]["steps"]
RUN = {step["name"]: step["run"] for step in JOB_STEPS if "run" in step}


def step(name: str, **given: str) -> subprocess.CompletedProcess[str]:
    given["PATH"] = f"{sysconfig.get_path('scripts')}:{os.environ['PATH']}"
    words = ["bash", "-e", "-c", RUN[name]]
    return subprocess.run(
        words, env=os.environ | given, capture_output=True, text=True, check=False
    )


def test_the_steps_of_the_workflow_hold_for_a_good_spec(heatwright: Heatwright) -> None:
    heatwright("generate chamber.yaml")
    assert [*RUN] == ["Install", "Check", "Compare", "Build", "Verify"]
    for name in [*RUN][1:]:
        done = step(name, SPEC="chamber")
        assert done.returncode == 0, done.stdout + done.stderr
    kept = JOB_STEPS[-1]["with"]["path"].split()
    assert {path.name for each in kept for path in Path().glob(each)} == {
        "firmware", "chamber.html",
    }  # fmt: skip


@pytest.mark.parametrize("name", ["Check", "Compare"])
def test_and_fail_where_something_is_wrong(heatwright: Heatwright, name: str) -> None:
    heatwright("generate oven.yaml")
    text = Path("oven.yaml").read_text("utf-8")
    old, new = ("board: uno", "board: duo") if name == "Check" else ("kp: 32  ", "kp: 31  ")
    Path("oven.yaml").write_text(text.replace(old, new, 1), "utf-8")
    assert step(name, SPEC="oven").returncode == (2 if name == "Check" else 1)


def test_what_is_installed_is_what_the_documents_ask_for() -> None:
    told = (ROOT / "docs" / "installing.md").read_text("utf-8")
    packages = re.search(r"install -qq (.*)", RUN["Install"])
    assert packages is not None
    assert [each for each in packages[1].split() if f"`{each}`" not in told] == []


def test_the_hook_is_offered_and_finds_a_mistake(heatwright: Heatwright) -> None:
    (offered,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text("utf-8"))
    (asked,) = HOOK["repos"][0]["hooks"]
    assert offered["id"] == asked["id"]
    assert re.search(asked["files"], "oven.yaml")
    assert not re.search(asked["files"], "generated/oven/x.yaml")
    heatwright(f"{offered['entry'].removeprefix('heatwright ')} oven.yaml chamber.yaml")
