"""How a command ends: an exit status, and at most a few lines that say why. Never a traceback."""

from __future__ import annotations

import contextlib
import errno
import os
import signal
import sys
import traceback
from enum import IntEnum
from types import FrameType
from typing import IO

import click


class Status(IntEnum):
    """What the process tells its caller."""

    DONE = 0
    FAILED = 1
    """The verification failed, or a comparison found differences."""
    REFUSED = 2
    """Bad spec, bad usage, or a file that cannot be read or written."""
    TOOL_MISSING = 3
    BUG = 70
    """EX_SOFTWARE of sysexits.h."""
    INTERRUPTED = 128 + signal.SIGINT
    NOBODY_READS = 128 + 13
    """SIGPIPE, as the shell reports it."""
    TERMINATED = 128 + signal.SIGTERM


COMPLETION = "_HEATWRIGHT_COMPLETE"
"""Set by the shell where completion is switched on; see click's "Shell Completion"."""


class Refused(Exception):
    """The command cannot be done; the text says what and how to put it right."""


def ended(command: click.Command, arguments: list[str]) -> int:
    """Run a command to its end; whatever happens, the result is an exit status."""
    _prepare_streams()
    try:
        status = _run(command, arguments)
        if sys.stdout is not None:
            sys.stdout.flush()
    except KeyboardInterrupt:
        return _silently_said("Interrupted.", Status.INTERRUPTED)
    except OSError as error:
        return _write_failed(error)
    return status


def _run(command: click.Command, arguments: list[str]) -> int:
    try:
        if COMPLETION in os.environ:  # the shell asks what could be typed next
            command.main(arguments, prog_name="heatwright")
        with command.make_context("heatwright", arguments) as context:
            result = command.invoke(context)
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except click.ClickException as error:
        error.show()
        return Status.REFUSED
    except (click.Abort, KeyboardInterrupt):
        raise KeyboardInterrupt from None
    except OSError as error:
        if error.filename is None:  # a stream of ours, not a file of the user's
            raise
        return _said(f"{_file(error)}: {unusable(error)}.", Status.REFUSED)
    except Exception as error:
        return _expected(error) or _bug(error, arguments)
    return result if isinstance(result, int) else Status.DONE


def _expected(error: Exception) -> int | None:
    """End with what went wrong outside this program; None for what is no such thing.

    The exceptions are known by where they are defined: importing them all takes too long for a
    command that ends well.
    """
    if isinstance(error, MemoryError):
        return _said("There is not enough memory: simulate a shorter time.", Status.REFUSED)
    status = _EXPECTED.get(f"{type(error).__module__}.{type(error).__name__}")
    return None if status is None else _said(str(error), status)


_EXPECTED = {
    "heatwright.cli.ends.Refused": Status.REFUSED,
    "heatwright.cli.fits.DoesNotFit": Status.REFUSED,
    "heatwright.spec.problems.SpecError": Status.REFUSED,
    "heatwright.generator.output.OutputRefused": Status.REFUSED,
    "heatwright.generator.toolchain.errors.BuildFailed": Status.REFUSED,
    "heatwright.generator.toolchain.errors.ToolMissing": Status.TOOL_MISSING,
    "heatwright.sim.native.shim.SimulatorMissing": Status.TOOL_MISSING,
    "heatwright.sim.avr.AvrError": Status.FAILED,
}


def _bug(error: Exception, arguments: list[str]) -> int:
    if "--debug" in arguments or os.environ.get("HEATWRIGHT_DEBUG"):
        traceback.print_exception(error)
    what = f"{type(error).__name__}: {error}".splitlines()[0].rstrip(".: ")
    return _said(
        f"heatwright has failed ({what}). That is a bug in it: please report it, with what\n"
        "HEATWRIGHT_DEBUG=1 heatwright … prints.",
        Status.BUG,
    )


def _write_failed(error: OSError) -> int:
    """End after standard output, or standard error, took no more."""
    with contextlib.suppress(OSError):  # so that Python finds nothing left to write at its end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if error.errno == errno.EPIPE:
        return Status.NOBODY_READS
    return _silently_said(f"The output cannot be written: {unusable(error)}.", Status.REFUSED)


def _said(text: str, status: int) -> int:
    click.echo(text, err=True)
    return status


def _silently_said(text: str, status: int) -> int:
    with contextlib.suppress(OSError, KeyboardInterrupt):
        click.echo(text, err=True)
    return status


def _file(error: OSError) -> str:
    return os.fsdecode(error.filename) if isinstance(error.filename, str | bytes) else "a file"


def unusable(error: OSError) -> str:
    """Say in a few words why a file cannot be used."""
    text = error.strerror or "it cannot be used"
    return text[:1].lower() + text[1:]


def _prepare_streams() -> None:
    """Write a replacement for what the terminal's encoding lacks instead of giving up."""
    for stream in (sys.stdout, sys.stderr):
        _lenient(stream)


def _lenient(stream: IO[str] | None) -> None:
    reconfigure = getattr(stream, "reconfigure", None)
    if reconfigure is not None:
        reconfigure(errors="replace")


def end_in_order() -> None:
    """Let a plain `kill` end the program as Ctrl-C does, with nothing left behind."""
    signal.signal(signal.SIGTERM, _terminate)


def _terminate(_: int, __: FrameType | None) -> None:
    raise SystemExit(Status.TERMINATED)
