"""`heatwright`: the list of commands, and how they are started."""

import os
import signal
import sys
from importlib import import_module

import click

from heatwright.cli.ends import end_in_order, ended
from heatwright.cli.options import Command

COMMANDS = (
    "init",
    "check",
    "schema",
    "size",
    "generate",
    "build",
    "upload",
    "monitor",
    "plot",
    "simulate",
    "bench",
    "verify",
    "compare",
    "campaign",
    "identify",
    "tune",
    "kinds",
    "new",
)
"""The commands, in the order in which a user needs them; each is a module of `commands`."""


class _Commands(Command, click.Group):
    """Imports the module of a command only when that command is used."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002 - click's interface
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = import_module(f"heatwright.cli.commands.{cmd_name}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Suggest similar names among all commands, also those not imported yet."""
        if args[0] not in COMMANDS and not args[0].startswith("-"):
            raise click.NoSuchCommand(args[0], possibilities=list(COMMANDS), ctx=ctx)
        return super().resolve_command(ctx, args)


def _version(ctx: click.Context, _: click.Parameter, asked: bool) -> None:
    if asked:
        from importlib.metadata import version  # noqa: PLC0415 - slow to import

        click.echo(f"heatwright {version('heatwright')}")
        ctx.exit()


@click.group(
    cls=_Commands,
    examples=(
        "heatwright init kiln.yaml        start a spec",
        "heatwright check kiln.yaml       find what is wrong with it",
        "heatwright verify kiln.yaml      generate, compile, simulate, compare with the model",
    ),
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_version,
    help="Show the version and stop.",
)
@click.option(
    "--debug",
    is_flag=True,
    envvar="HEATWRIGHT_DEBUG",
    show_envvar=True,
    help="Print the traceback of an unexpected error.",
)
def cli(debug: bool) -> None:
    """Firmware for thermal machines: generated from one YAML file, compiled, proven.

    Exit status: 0 done, 1 verification failed, 2 bad spec or usage, 3 a tool is missing.
    """


def main() -> None:
    """Run the command line and end the process with its status."""
    # Pydantic's search for plug-ins takes longer than reading a spec.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # Matrices here have four rows: OpenBLAS's threads would only occupy a core while they wait.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    end_in_order()
    status = ended(cli, sys.argv[1:])
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the command is over
    sys.exit(status)
