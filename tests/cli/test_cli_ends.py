"""How commands end: statuses, one line for the reason, nothing left behind."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import IO, Any

import click
import pytest
from rig.specs import EXAMPLES

from heatwright.cli.ends import Refused, ended
from heatwright.generator.toolchain import BuildFailed, ToolMissing
from heatwright.sim.avr import AvrError
from heatwright.sim.native.shim import SimulatorMissing

PROGRAM = [sys.executable, "-m", "heatwright.cli.main"]
CHAMBER = str(EXAMPLES / "chamber.yaml")


def failing(error: BaseException) -> click.Command:
    """A command that fails in this way."""

    @click.command()
    def command() -> None:
        raise error

    return command


@pytest.mark.parametrize(
    ("error", "status", "expected"),
    [
        (Refused("Not so."), 2, "Not so.\n"),
        (ToolMissing("no compiler: install it"), 3, "no compiler: install it\n"),
        (SimulatorMissing("no simavr: install it"), 3, "no simavr: install it\n"),
        (BuildFailed("does not fit"), 2, "does not fit\n"),
        (AvrError("crashed"), 1, "crashed\n"),
        (MemoryError(), 2, "There is not enough memory: simulate a shorter time.\n"),
        (KeyboardInterrupt(), 130, "Interrupted.\n"),
        (OSError(errno.ENOSPC, "No space left on device", "a.png"), 2, "a.png: no space left"),
        (OSError(errno.ENOSPC, "No space left on device"), 2, "The output cannot be written"),
        (OSError(errno.EPIPE, "Broken pipe"), 141, ""),
        (ZeroDivisionError("oh"), 70, "heatwright has failed (ZeroDivisionError: oh)"),
    ],
)
def test_errors_become_statuses(
    error: BaseException, status: int, expected: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert ended(failing(error), []) == status
    told = capfd.readouterr().err
    assert expected in told if expected else told == ""
    assert "Traceback" not in told


def test_a_bug_shows_its_place_where_asked_for(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HEATWRIGHT_DEBUG", "1")
    assert ended(failing(ZeroDivisionError("oh")), []) == 70
    assert "Traceback" in capfd.readouterr().err


def started(*words: object, **streams: Any) -> subprocess.Popen[str]:
    """Start a command as a process of its own."""
    return subprocess.Popen(
        [*PROGRAM, *map(str, words)], stderr=subprocess.PIPE, text=True, **streams
    )


def said(process: subprocess.Popen[str]) -> IO[str]:
    assert process.stderr is not None
    return process.stderr


def test_a_reader_that_goes_away_is_no_error() -> None:
    with started("schema", stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.close()
        assert said(process).read() == ""
    assert process.returncode == 141


def test_a_full_disk_is_told_in_a_line() -> None:
    with Path("/dev/full").open("w") as full, started("schema", stdout=full) as process:
        assert said(process).read() == "The output cannot be written: no space left on device.\n"
    assert process.returncode == 2


def test_a_poor_terminal_gets_replacements() -> None:
    surroundings = os.environ | {"PYTHONIOENCODING": "ascii", "COLUMNS": "60"}
    words = ("simulate", CHAMBER, "--model", "--for", "5 s")
    with started(*words, stdout=subprocess.DEVNULL, env=surroundings) as process:
        assert "Traceback" not in said(process).read()
    assert process.returncode == 0


@pytest.mark.parametrize(("sign", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_simulation_leaves_nothing(
    tmp_path: Path, sign: signal.Signals, status: int
) -> None:
    words = ("simulate", CHAMBER, "--model", "--for", "20 d", "--csv", tmp_path / "x.csv")
    with started(*words, stdout=subprocess.PIPE, cwd=tmp_path) as process:
        assert said(process).readline() == "Simulating the model …\n"
        process.send_signal(sign)
        assert said(process).read() == ("Interrupted.\n" if sign == signal.SIGINT else "")
    assert process.returncode == status
    assert list(tmp_path.iterdir()) == []


def _group_ends(group: int, within_s: float) -> bool:
    """Whether no process of a group is left; the last ones may still be on their way out."""
    deadline = time.monotonic() + within_s
    while time.monotonic() < deadline:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.01)
    return False


def test_an_interrupted_comparison_ends_its_workers(tmp_path: Path) -> None:
    words = ("compare", EXAMPLES / "oven.yaml", "--model")
    with started(*words, stdout=subprocess.PIPE, cwd=tmp_path, start_new_session=True) as process:
        said(process).readline()
        os.killpg(process.pid, signal.SIGINT)
        assert said(process).read().splitlines()[-1] == "Interrupted."
    assert process.returncode == 130
    assert _group_ends(process.pid, within_s=60)
