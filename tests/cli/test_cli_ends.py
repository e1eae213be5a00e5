"""How commands and their workers end, and what is told of them: help and documents. A start imports
little. docs/commands.md has each command and option. Each command of the tutorial is run, in its
order, and prints what stands there. What `docs/ci.md` has users put into their repositories does
there what it says."""

import errno
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import sysconfig
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import chain
from pathlib import Path
from typing import Any
from unittest.mock import Mock, call

import click
import pytest
import yaml
from rig.commands import Heatwright
from rig.firmware import EXAMPLES, ROOT, finished

from heatwright.cli.bars import Bars
from heatwright.cli.ends import Refused, ended
from heatwright.cli.main import COMMANDS, cli
from heatwright.cli.pool import WorkerDied, spread
from heatwright.cli.talk import Job
from heatwright.generator.toolchain import BuildFailed, ToolMissing
from heatwright.sim.avr import AvrError
from heatwright.sim.native.shim import SimulatorMissing

PROGRAM = [sys.executable, "-m", "heatwright.cli.start"]
CHAMBER = str(EXAMPLES / "chamber.yaml")


def failing(error: BaseException) -> click.Command:
    option = click.Option(["--json"], is_flag=True)
    return click.Command("failing", params=[option], callback=Mock(side_effect=error))


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
        (OSError(errno.ENOSPC, "No space", "a.png"), 2, "a.png: cannot be used: no space.\n"),
        (OSError(errno.ENOSPC, "No space left on device"), 2, "The output cannot be written"),
        (OSError(errno.EPIPE, "Broken pipe"), 141, ""),
        (OSError(errno.EACCES, "Denied"), 2, "refused a call (_execute_mock_call): d"),
        (ZeroDivisionError("oh"), 70, "heatwright has failed (ZeroDivisionError: oh)"),
    ],
)
def test_errors_become_statuses(
    error: BaseException, status: int, expected: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert ended(failing(error), ["--json"]) == status
    found, told = capfd.readouterr()
    assert expected in told if expected else told == ""
    assert "Traceback" not in told
    if found or not isinstance(error, OSError):  # of a stream: there may be nobody who reads
        assert json.loads(found) == {"status": status, "error": told.strip(), "problems": []}


def test_a_bug_shows_its_place_where_asked_for(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HEATWRIGHT_DEBUG", "1")
    assert ended(failing(ZeroDivisionError("oh")), []) == 70
    assert "Traceback" in capfd.readouterr().err


@contextmanager
def started(*words: object, stdout: Any = subprocess.PIPE, **more: Any) -> Iterator[Any]:
    line = [*PROGRAM, *map(str, words)]
    pipes = {"stdout": stdout, "stderr": subprocess.PIPE}
    with subprocess.Popen(line, text=True, **pipes, **more) as process:
        yield process


def test_a_reader_that_goes_away_is_no_error_and_a_full_disk_is_told_in_a_line() -> None:
    with started("schema") as process:
        process.stdout.close()
        assert process.stderr.read() == ""
    assert process.returncode == 141
    with Path("/dev/full").open("w") as full, started("schema", stdout=full) as process:
        assert process.stderr.read() == "The output cannot be written: no space left on device.\n"
    assert process.returncode == 2


def test_a_poor_terminal_gets_replacements() -> None:
    surroundings = os.environ | {"PYTHONIOENCODING": "ascii", "COLUMNS": "60"}
    words = ("simulate", CHAMBER, "--model", "--for", "5 s")
    with started(*words, stdout=subprocess.DEVNULL, env=surroundings) as process:
        assert "Traceback" not in process.stderr.read()
    assert process.returncode == 0


@pytest.mark.parametrize(("sign", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_simulation_leaves_nothing(
    tmp_path: Path, sign: signal.Signals, status: int
) -> None:
    words = ("simulate", CHAMBER, "--model", "--for", "20 d", "--csv", tmp_path / "x.csv")
    with started(*words, cwd=tmp_path) as process:
        assert process.stderr.readline() == "Simulating the model …\n"
        process.send_signal(sign)
        assert process.stderr.read() == ("Interrupted.\n" if sign == signal.SIGINT else "")
    assert process.returncode == status
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["click", "pydantic", "yaml", "numpy", "heatwright.cli.results"])
def test_an_interrupted_import_ends_as_any_work(name: str) -> None:
    program = f"""import os, sys
sys.addaudithook(lambda what, of: (what, of[0]) == ("import", {name!r}) and os.kill(os.getpid(), 2))
from heatwright.cli.start import main
main()"""
    words = [sys.executable, "-c", program, "simulate", CHAMBER, "--model", "--for", "5s", "--json"]
    done = finished(words)
    assert (done.returncode, done.stderr.split("…\n")[-1]) == (130, "Interrupted.\n")
    assert json.loads(done.stdout) == {"status": 130, "error": "Interrupted.", "problems": []}


@pytest.mark.parametrize("name", ["-", "/dev/stdin"])
def test_a_spec_comes_through_a_pipe(name: str) -> None:
    text = Path(CHAMBER).read_text(encoding="utf-8")
    told = subprocess.check_output([*PROGRAM, "check", name], input=text, text=True)
    assert told.startswith(f"{name}: good\n")


def group_ends(group: int, within_s: float) -> bool:
    """Whether no process of a group is left; the last ones may still be on their way out."""
    deadline = time.monotonic() + within_s
    with suppress(ProcessLookupError):
        while time.monotonic() < deadline:
            os.killpg(group, 0)
            time.sleep(0.01)
        return False
    return True


def test_an_interrupted_comparison_ends_its_workers(tmp_path: Path) -> None:
    words = ("compare", EXAMPLES / "oven.yaml", "--model")
    with started(*words, cwd=tmp_path, start_new_session=True) as process:
        process.stderr.readline()
        os.killpg(process.pid, signal.SIGINT)
        assert process.stderr.read().splitlines()[-1] == "Interrupted."
    assert process.returncode == 130
    assert group_ends(process.pid, within_s=60)


def double(piece: int, job: Job) -> int:
    job.note(f"doubling {piece}")
    job(piece, 10)
    return 2 * piece


def refuse(piece: int, _: Job) -> int:
    if piece == 2:
        raise Refused("not two")
    return piece


def die(_: int, __: Job) -> int:
    os.kill(os.getpid(), signal.SIGKILL)
    return 0


def test_results_come_in_order_and_progress_goes_to_its_job() -> None:
    jobs = [Mock() for _ in range(3)]
    assert spread(double, [3, 1, 2], jobs) == [6, 2, 4]
    for piece, job in zip([3, 1, 2], jobs, strict=True):
        *heard, last = job.mock_calls
        assert last == call.end()
        assert all(each in (call.note(f"doubling {piece}"), call(piece, 10)) for each in heard)


def test_an_error_comes_through_and_a_worker_that_dies_is_noticed() -> None:
    with pytest.raises(Refused, match="not two"):
        spread(refuse, [1, 2], [Mock(), Mock()])
    with pytest.raises(WorkerDied):
        spread(die, [1], [Mock()])


def test_nothing_is_drawn_while_a_process_is_forked() -> None:
    bars, drawn = Bars(), []
    shown = bars._progress.live
    os.register_at_fork(before=lambda: drawn.append(shown.is_started))
    with bars:
        assert spread(double, [1], [bars.begin("Doubling")]) == [2]
        assert shown.is_started
    assert spread(double, [1], [Mock()]) == [2]
    assert not shown.is_started
    assert drawn == [False, False]


PAGE = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
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
        ("check --quick CHAMBER", HEAVY | {"jinja2", "difflib"}),
        ("check CHAMBER", HEAVY - {"numpy", "scipy", "elftools"} | {"PIL", "jinja2"}),
        ("generate CHAMBER -o out", HEAVY), ("generate CHAMBER -o out --check", HEAVY),
        ("init new.yaml", HEAVY),
    ],
)  # fmt: skip
def test_nothing_heavy_is_imported(words: str, banned: set[str], tmp_path: Path) -> None:
    arguments = [word.replace("CHAMBER", f"{EXAMPLES}/chamber.yaml") for word in words.split()]
    program = (
        "import sys\nfrom heatwright.cli.ends import ended\nfrom heatwright.cli.main import cli\n"
        f"ended(cli, {arguments!r})\n"
        f"print(sorted({banned!r} & {{name.partition('.')[0] for name in sys.modules}}))\n"
    )
    told = subprocess.check_output([sys.executable, "-c", program], text=True, cwd=tmp_path)
    assert told.splitlines()[-1] == "[]"


DOCS = ROOT / "docs"
TEXT = (DOCS / "tutorial.md").read_text(encoding="utf-8")
CONSOLES = "".join(re.findall(r"```console\n(.*?)```", TEXT, re.DOTALL))
STEPS = re.findall(r"^\$ (.*)\n((?:[^$].*\n)*)", CONSOLES, re.M)  # command, and what it prints


def pattern(printed: str) -> str:
    """Make a line of … match any lines, and … within a line anything there."""
    lines = printed.splitlines(keepends=True)
    return "".join(
        "(?:.*\n)*" if line == "…\n" else re.escape(line).replace("…", ".+") for line in lines
    )


@pytest.mark.parametrize(
    ("found", "fits"),
    [
        ("a\nb 1 c\n", True), ("a\nx\ny\nb 2 c\n", True), ("a\nb 2\n", False),
        ("a\nb 2\n c\n", False),
    ],
)  # fmt: skip
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
    return finished(["bash", "-e", "-c", RUN[name]], env=os.environ | given)


def test_the_steps_of_the_workflow_hold_for_a_good_spec(heatwright: Heatwright) -> None:
    heatwright("generate chamber.yaml")
    assert [*RUN] == ["Install", "Check", "Compare", "Build", "Verify"]
    for name in [*RUN][1:]:
        done = step(name, SPEC="chamber")
        assert done.returncode == 0, done.stdout + done.stderr
    kept = JOB_STEPS[-1]["with"]["path"].split()
    found = {path.name for each in kept for path in Path().glob(each)}
    assert found == {"firmware", "chamber.html"}


@pytest.mark.parametrize("name", ["Check", "Compare"])
def test_and_fail_where_something_is_wrong(heatwright: Heatwright, name: str) -> None:
    heatwright("generate oven.yaml")
    text = Path("oven.yaml").read_text("utf-8")
    old, new = ("board: uno", "board: duo") if name == "Check" else ("kp: 32  ", "kp: 31  ")
    Path("oven.yaml").write_text(text.replace(old, new, 1), "utf-8")
    assert step(name, SPEC="oven").returncode == (2 if name == "Check" else 1)


def test_what_is_installed_is_what_the_documents_ask_for() -> None:
    told = (ROOT / "docs" / "installing.md").read_text("utf-8")
    (packages,) = re.findall(r"install -qq (.*)", RUN["Install"])
    assert [each for each in packages.split() if f"`{each}`" not in told] == []


def test_the_hook_is_offered_and_finds_a_mistake(heatwright: Heatwright) -> None:
    (offered,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text("utf-8"))
    (asked,) = HOOK["repos"][0]["hooks"]
    assert offered["id"] == asked["id"]
    assert re.search(asked["files"], "oven.yaml")
    assert not re.search(asked["files"], "generated/oven/x.yaml")
    heatwright(f"{offered['entry'].removeprefix('heatwright ')} oven.yaml chamber.yaml")
