"""Help, the page docs/commands.md, and a start that imports nothing heavy."""

import re
import subprocess
import sys
from itertools import chain
from pathlib import Path

import click
import pytest
from rig.commands import Heatwright
from rig.specs import EXAMPLES

from heatwright.cli.main import COMMANDS, cli

PAGE = (Path(__file__).parents[2] / "docs" / "commands.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"^## (\w+)\n(.*?)(?=^## |\Z)", PAGE, re.DOTALL | re.MULTILINE))
HEAVY = {"numpy", "scipy", "matplotlib", "rich", "elftools", "cffi", "platformio", "vcd", "control"}
LANGUAGE = {"pydantic", "yaml", "jinja2"}


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_every_command_has_help_with_an_example(heatwright: Heatwright, command: str) -> None:
    told = heatwright(f"{command} --help").out
    assert "Example" in told
    assert f"  heatwright {command or 'init'} " in told
    assert "..." not in told.partition("Commands:")[2], "the list is cut short"


def test_every_command_has_its_section_in_order(heatwright: Heatwright) -> None:
    assert heatwright("--version").out.startswith("heatwright 0.")
    assert tuple(name for name in SECTIONS if name != "Completion") == COMMANDS


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_is_told_and_no_other(name: str) -> None:
    command = cli.get_command(click.Context(cli), name)
    assert command is not None
    options = [each.opts for each in command.params if isinstance(each, click.Option)]
    assert set(re.findall(r"(?<![\w-])--?[a-z]+(?![\w-])", SECTIONS[name])) == set(chain(*options))


@pytest.mark.parametrize(
    ("words", "banned"),
    [
        *((f"{command} --help", HEAVY | LANGUAGE)
          for command in ("", "generate", "verify", "identify", "tune")),
        ("check CHAMBER", HEAVY | {"jinja2", "difflib"}),
        ("generate CHAMBER -o out", HEAVY),
        ("generate CHAMBER -o out --check", HEAVY),
        ("init new.yaml", HEAVY),
    ],
)  # fmt: skip
def test_nothing_heavy_is_imported(words: str, banned: set[str], tmp_path: Path) -> None:
    arguments = [word.replace("CHAMBER", f"{EXAMPLES}/chamber.yaml") for word in words.split()]
    program = (
        "import sys\n"
        "from heatwright.cli.ends import ended\n"
        "from heatwright.cli.main import cli\n"
        f"ended(cli, {arguments!r})\n"
        f"print(sorted({banned!r} & {{name.partition('.')[0] for name in sys.modules}}))\n"
    )
    told = subprocess.check_output([sys.executable, "-c", program], text=True, cwd=tmp_path)
    assert told.splitlines()[-1] == "[]"
