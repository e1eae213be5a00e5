"""How a command ends: an exit status, and at most a few lines that say why. Never a traceback."""

import contextlib
import errno
import os
import signal
import sys
import traceback
from enum import IntEnum
from io import StringIO
from types import FrameType
from typing import Any, NamedTuple

import click


class Status(IntEnum):
    """Exit status of the process."""

    DONE = 0
    FAILED = 1
    """The command has worked, and found failed checks, differences, missing pieces or no gains."""
    REFUSED = 2
    """Bad spec, bad usage, a firmware that cannot be built, or a file that cannot be used."""
    TOOL_MISSING = 3
    BUG = 70
    """EX_SOFTWARE of sysexits.h."""
    INTERRUPTED = 128 + signal.SIGINT
    NOBODY_READS = 128 + 13
    """SIGPIPE, as the shell reports it."""
    TERMINATED = 128 + signal.SIGTERM


JSON_TOLD = "JSON is told"
"""Key that is set in click's context once a command has printed JSON: it prints only one object."""
UNWRITTEN = "cannot be written"
"""Note that is added to an error of writing; `spec.loading.user_file` adds one of reading."""

_OF_STREAMS = {
    errno.EPIPE, errno.ENOSPC, errno.EIO, errno.EBADF, errno.EFBIG, errno.EDQUOT, errno.EAGAIN,
}  # fmt: skip
"""Error numbers of a failed write to standard output or standard error."""

COMPLETION = "_HEATWRIGHT_COMPLETE"
"""Set by the shell where completion is switched on; see click's "Shell Completion"."""


class Refused(Exception):
    """The command cannot be executed; the text says why, and what to do about it."""


class _End(NamedTuple):
    """The end of a command: its status, and the reason if the command failed."""

    status: int
    text: str = ""
    problems: tuple[Any, ...] = ()
    """Each problem of the spec, with its place."""


_INTERRUPTED = _End(Status.INTERRUPTED, "Interrupted.")


def ended(command: click.Command, arguments: list[str]) -> int:
    """Run a command to its end; whatever happens, the result is an exit status."""
    _prepare_streams()
    told: dict[str, Any] = {}
    try:
        end = _run(command, arguments, told)
        if end is not _INTERRUPTED:
            _tell(end, arguments, told)
            _flush()
            return end.status
    except KeyboardInterrupt:
        end = _INTERRUPTED
    except OSError as error:
        return _write_failed(error)
    with contextlib.suppress(OSError, KeyboardInterrupt):
        _tell(end, arguments, told)
        _flush()
    return end.status


def _run(command: click.Command, arguments: list[str], told: dict[str, Any]) -> _End:
    try:
        if COMPLETION in os.environ:  # the shell requests completions
            command.main(arguments, prog_name="heatwright")
        with command.make_context("heatwright", [*arguments], obj=told) as context:
            result = command.invoke(context)
    except click.exceptions.Exit as stop:
        return _End(stop.exit_code)
    except click.ClickException as error:
        return _misused(error)
    except (click.Abort, KeyboardInterrupt):
        return _INTERRUPTED
    except Exception as error:
        if isinstance(error, OSError) and error.filename is None and error.errno in _OF_STREAMS:
            raise
        if _Signals.interrupted:  # a library may have turned the Ctrl-C into another error
            return _INTERRUPTED
        return _expected(error) or _bug(error, arguments)
    return _End(result if isinstance(result, int) else Status.DONE)


def _tell(end: _End, arguments: list[str], told: dict[str, Any]) -> None:
    """Print why a command failed: a few lines, and JSON if --json was given."""
    if not end.text:
        return
    click.echo(end.text, err=True)
    options = arguments[: arguments.index("--")] if "--" in arguments else arguments
    if "--json" in options and JSON_TOLD not in told:
        from json import dumps  # noqa: PLC0415 - only with --json

        problems = [problem._asdict() for problem in end.problems]
        failed = {"status": int(end.status), "error": end.text, "problems": problems}
        click.echo(dumps(failed, indent=2, ensure_ascii=False))


def _flush() -> None:
    if sys.stdout is not None:
        sys.stdout.flush()


def _misused(error: click.ClickException) -> _End:
    """Return the end for a wrong command line: the command's usage, and the error."""
    said = StringIO()
    error.show(said)
    return _End(Status.REFUSED, said.getvalue().rstrip("\n"))


def _expected(error: Exception) -> _End | None:
    """Return the end for an error with a cause outside this program; None for any other error.

    Exceptions are recognised by module and name: importing them all would slow down every command
    that ends well.
    """
    if isinstance(error, MemoryError):
        return _End(Status.REFUSED, "There is not enough memory: simulate a shorter time.")
    if isinstance(error, OSError):
        return _End(Status.REFUSED, _file_failed(error))
    status = _EXPECTED.get(f"{type(error).__module__}.{type(error).__name__}")
    return None if status is None else _End(status, str(error), getattr(error, "problems", ()))


_EXPECTED = {
    "heatwright.cli.ends.Refused": Status.REFUSED,
    "heatwright.cli.fits.DoesNotFit": Status.REFUSED,
    "heatwright.spec.problems.SpecError": Status.REFUSED,
    "heatwright.spec.registry.KindIncomplete": Status.REFUSED,
    "heatwright.generator.output.OutputRefused": Status.REFUSED,
    "heatwright.generator.toolchain.errors.BuildFailed": Status.REFUSED,
    "heatwright.generator.toolchain.errors.ToolMissing": Status.TOOL_MISSING,
    "heatwright.sim.native.shim.SimulatorMissing": Status.TOOL_MISSING,
    "heatwright.sim.avr.AvrError": Status.FAILED,
}


def _bug(error: Exception, arguments: list[str]) -> _End:
    if "--debug" in arguments or os.environ.get("HEATWRIGHT_DEBUG"):
        traceback.print_exception(error)
    what = f"{type(error).__name__}: {error}".splitlines()[0].rstrip(".: ")
    if package := _package_of(error):
        return _End(
            Status.REFUSED,
            f"The package {package} has failed ({what}). `heatwright kinds` lists what it lacks;\n"
            "HEATWRIGHT_DEBUG=1 heatwright … prints the traceback.",
        )
    return _End(
        Status.BUG,
        f"heatwright has failed ({what}). That is a bug in it: please report it, with what\n"
        "HEATWRIGHT_DEBUG=1 heatwright … prints.",
    )


def _package_of(error: Exception) -> str:
    """Name the outside package whose code has raised an error; "" if it is heatwright's own.

    An error raised in a library belongs to the code that called the library.
    """
    from heatwright.spec.registry import packages  # noqa: PLC0415 - only for a bug

    ours = "heatwright"
    places = (frame.f_globals["__name__"] for frame, _ in traceback.walk_tb(error.__traceback__))
    owners = [
        owner
        for place in places
        for owner in (*packages(), ours)
        if f"{place}.".startswith(f"{owner}.")
    ]
    return "" if owners[-1:] == [ours] else "".join(owners[-1:])


def _write_failed(error: OSError) -> int:
    """Return the status after a write to standard output or standard error has failed."""
    with contextlib.suppress(OSError):  # else Python fails once more when it flushes at its end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if error.errno == errno.EPIPE:
        return Status.NOBODY_READS
    with contextlib.suppress(OSError, KeyboardInterrupt):
        click.echo(f"The output cannot be written: {unusable(error)}.", err=True)
    return Status.REFUSED


def _file_failed(error: OSError) -> str:
    """Say which file cannot be read or written, and why."""
    if not isinstance(error.filename, str | bytes):
        calls = traceback.extract_tb(error.__traceback__)
        return f"The operating system refused a call ({calls[-1].name}): {unusable(error)}."
    what = next(iter(getattr(error, "__notes__", ())), "cannot be used")
    return f"{os.fsdecode(error.filename)}: {what}: {unusable(error)}."


def unusable(error: OSError) -> str:
    """Say in a few words why a file cannot be used."""
    text = error.strerror or "it cannot be used"
    return text[:1].lower() + text[1:]


def _prepare_streams() -> None:
    """Replace characters that the terminal's encoding lacks, instead of failing."""
    for stream in (sys.stdout, sys.stderr):
        if reconfigure := getattr(stream, "reconfigure", None):
            reconfigure(errors="replace")


class _Signals:
    """Whether Ctrl-C has interrupted the command."""

    interrupted = False


def end_in_order() -> None:
    """Let a plain `kill` end the program as Ctrl-C does, with nothing left behind."""
    signal.signal(signal.SIGTERM, _terminate)
    signal.signal(signal.SIGINT, _interrupt)


def _terminate(_: int, __: FrameType | None) -> None:
    raise SystemExit(Status.TERMINATED)


def _interrupt(_: int, __: FrameType | None) -> None:
    _Signals.interrupted = True
    raise KeyboardInterrupt
