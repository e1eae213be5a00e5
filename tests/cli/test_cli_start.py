"""`generate`, `check` and `--help` start at once: they import nothing heavy."""

import subprocess
import sys
from pathlib import Path

import pytest
from conftest import EXAMPLES

HEAVY = {"numpy", "scipy", "matplotlib", "rich", "elftools", "cffi", "platformio", "vcd", "control"}
LANGUAGE = {"pydantic", "yaml", "jinja2"}
CHAMBER = str(EXAMPLES / "chamber.yaml")


@pytest.mark.parametrize(
    ("words", "banned"),
    [
        (["--help"], HEAVY | LANGUAGE),
        (["generate", "--help"], HEAVY | LANGUAGE),
        (["verify", "--help"], HEAVY | LANGUAGE),
        (["identify", "--help"], HEAVY | LANGUAGE),
        (["tune", "--help"], HEAVY | LANGUAGE),
        (["check", CHAMBER], HEAVY | {"jinja2"}),
        (["generate", CHAMBER, "-o", "out"], HEAVY),
        (["generate", CHAMBER, "-o", "out", "--check"], HEAVY),
        (["init", "new.yaml"], HEAVY),
    ],
)
def test_nothing_heavy_is_imported(words: list[str], banned: set[str], tmp_path: Path) -> None:
    program = (
        "import sys\n"
        "from heatwright.cli.ends import ended\n"
        "from heatwright.cli.main import cli\n"
        f"ended(cli, {words!r})\n"
        f"print(sorted({banned!r} & {{name.partition('.')[0] for name in sys.modules}}))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, cwd=tmp_path, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]"
