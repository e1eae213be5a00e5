"""How commands end: statuses, one line for the reason, nothing left behind."""

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import click
import pytest
from conftest import EXAMPLES, Heatwright

from heatwright.cli.ends import Refused, ended
from heatwright.cli.main import COMMANDS
from heatwright.generator.toolchain import BuildFailed, ToolMissing
from heatwright.sim.avr import AvrError
from heatwright.sim.native.shim import SimulatorMissing

PROGRAM = [sys.executable, "-m", "heatwright.cli.main"]
CHAMBER = str(EXAMPLES / "chamber.yaml")


@pytest.mark.parametrize("words", [("--help",), *((name, "--help") for name in COMMANDS)])
def test_every_command_has_help_with_an_example(
    heatwright: Heatwright, words: tuple[str, ...]
) -> None:
    done = heatwright(*words)
    assert done.status == 0
    assert f"  heatwright {words[0] if len(words) > 1 else 'init'} " in done.out
    assert "Example" in done.out


def test_the_list_of_commands_is_not_cut_short(heatwright: Heatwright) -> None:
    _, listed = heatwright("--help").out.split("Commands:")
    assert "..." not in listed


def test_version(heatwright: Heatwright) -> None:
    assert heatwright("--version").out.startswith("heatwright 0.")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ((), "Usage:"),
        (("generat", "x.yaml"), "Did you mean 'generate'?"),
        (("generate",), "Missing argument 'SPEC'"),
        (("generate", "chamber.yaml", "--chekc"), "'--check'"),
        (("generate", "none.yaml"), "none.yaml: no such file or directory.\n"),
        (("generate", "."), ".: is a directory.\n"),
        (("simulate", "chamber.yaml", "--for", "3"), "3 has no unit"),
        (("simulate", "chamber.yaml", "--for", "-1 s"), "-1 s is too small"),
        (("simulate", "chamber.yaml", "--plot", "x.pdf"), "x.pdf: name it with .png or"),
        (("simulate", "chamber.yaml", "--csv", "none/x.csv"), "there is no folder none"),
        (("simulate", "chamber.yaml", "--csv", "."), ".: is a folder"),
        (("simulate", "chamber.yaml", "--model", "--vcd", "x.vcd"), "The model has no pins"),
        (("compare", "chamber.yaml"), "chamber.yaml: has no `comparison`"),
        (("compare", "oven.yaml", "--algorithm", "none"), "no row is called none; there are"),
        (("build", "chamber.yaml", "-o", "oven.yaml"), "oven.yaml: is a file"),
        (("simulate", "chamber.yaml", "--scenario", "none.yaml"), "none.yaml: no such file"),
    ],
)
def test_bad_usage_is_refused_with_the_reason(
    heatwright: Heatwright, words: tuple[str, ...], expected: str
) -> None:
    done = heatwright(*words)
    assert done.status == 2
    assert expected in done.err
    assert done.out == ""


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
    error: BaseException, status: int, expected: str, tmp_path: Path
) -> None:
    script = tmp_path / "fails.py"
    script.write_text(
        "import sys, click\n"
        "from test_cli_ends import failing\n"
        "from heatwright.cli.ends import ended\n"
        f"sys.exit(ended(failing({error.__class__.__name__!r}, {_arguments(error)!r}), []))\n",
        encoding="utf-8",
    )
    surroundings = os.environ | {"PYTHONPATH": str(Path(__file__).parent)}
    done = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, env=surroundings, check=False
    )
    assert done.returncode == status
    assert expected in done.stderr if expected else done.stderr == ""
    assert "Traceback" not in done.stderr


def _arguments(error: BaseException) -> tuple[object, ...]:
    """What the error was made of; an OSError keeps its file apart."""
    file = getattr(error, "filename", None)
    return (*error.args, file) if file else error.args


def failing(name: str, arguments: tuple[object, ...]) -> click.Command:
    """A command that fails in this way."""
    error = globals().get(name) or __builtins__[name]  # type: ignore[index]

    @click.command()
    def command() -> None:
        raise error(*arguments)

    return command


def test_a_bug_shows_its_place_where_asked_for(capfd: pytest.CaptureFixture[str]) -> None:
    assert ended(failing("ZeroDivisionError", ("oh",)), []) == 70
    assert "Traceback" not in capfd.readouterr().err
    os.environ["HEATWRIGHT_DEBUG"] = "1"
    try:
        ended(failing("ZeroDivisionError", ("oh",)), [])
    finally:
        del os.environ["HEATWRIGHT_DEBUG"]
    assert "Traceback" in capfd.readouterr().err


def test_a_reader_that_goes_away_is_no_error() -> None:
    with subprocess.Popen(
        [*PROGRAM, "schema"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 141


def test_a_full_disk_is_told_in_a_line() -> None:
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        done = subprocess.run(
            [*PROGRAM, "schema"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (done.returncode, done.stderr) == (
        2,
        "The output cannot be written: no space left on device.\n",
    )


def test_a_poor_terminal_gets_replacements() -> None:
    surroundings = os.environ | {"PYTHONIOENCODING": "ascii", "COLUMNS": "60"}
    done = subprocess.run(
        [*PROGRAM, "simulate", CHAMBER, "--model", "--for", "5 min"],
        capture_output=True, env=surroundings, check=False,
    )  # fmt: skip
    assert done.returncode == 0
    assert b"Traceback" not in done.stderr


@pytest.mark.parametrize(("sign", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_simulation_leaves_nothing(
    tmp_path: Path, sign: signal.Signals, status: int
) -> None:
    with subprocess.Popen(
        [*PROGRAM, "simulate", CHAMBER, "--model", "--for", "20 d", "--csv", tmp_path / "x.csv"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path,
    ) as process:  # fmt: skip
        assert process.stderr is not None
        assert process.stderr.readline() == "Simulating the model …\n"
        process.send_signal(sign)
        assert process.stderr.read() == ("Interrupted.\n" if sign == signal.SIGINT else "")
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
    oven = str(EXAMPLES / "oven.yaml")
    with subprocess.Popen(
        [*PROGRAM, "compare", oven, "--model"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path,
        start_new_session=True,
    ) as process:  # fmt: skip
        assert process.stderr is not None
        process.stderr.readline()
        os.killpg(process.pid, signal.SIGINT)
        assert process.stderr.read().splitlines()[-1] == "Interrupted."
    assert process.returncode == 130
    assert _group_ends(process.pid, within_s=10)
