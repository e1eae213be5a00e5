"""docs/commands.md tells of every command and option, and of none that there is not."""

import re
from pathlib import Path

import click

from heatwright.cli.main import COMMANDS, cli

PAGE = (Path(__file__).parents[2] / "docs" / "commands.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"^## (\w+)\n(.*?)(?=^## |\Z)", PAGE, re.DOTALL | re.MULTILINE))


def options(command: click.Command) -> set[str]:
    return {
        name
        for parameter in command.params
        if isinstance(parameter, click.Option)
        for name in parameter.opts
    }


def test_every_command_has_its_section_in_order() -> None:
    assert tuple(name for name in SECTIONS if name != "Completion") == COMMANDS


def test_every_option_is_told_and_no_other() -> None:
    context = click.Context(cli)
    for name in COMMANDS:
        command = cli.get_command(context, name)
        assert command is not None
        told = set(re.findall(r"(?<![\w-])--?[a-z]+(?![\w-])", SECTIONS[name]))
        assert told == options(command), name
