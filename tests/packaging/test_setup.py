"""What tools/setup.sh asks for, and what it says when it does not get it."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "tools" / "setup.sh"
FAKES = {
    "id": "echo 1000",
    "sudo": 'echo "$*" >>asked; exit $SUDO_STATUS',
    "apt-get": "",
    "python3": f'exec {sys.executable} "$@"',
}


@pytest.mark.parametrize(
    ("for_tests", "status", "said"),
    [
        ("", 1, "not installed, as root was not granted; as root: apt-get install gcc-avr"),
        ("1", 100, "failed: sudo apt-get update"),  # as without a network
    ],
)
def test_it_asks_for_what_is_needed(for_tests: str, status: int, said: str, tmp_path: Path) -> None:
    (tmp_path / "tools").mkdir()
    shutil.copy(SCRIPT, tmp_path / "tools")
    for name in ("bash", "dirname", "mkdir", "tail"):
        (tmp_path / name).symlink_to(shutil.which(name) or name)
    for name, text in FAKES.items():
        (tmp_path / name).write_text(f"#!{tmp_path}/bash\n{text}\n", encoding="utf-8")
        (tmp_path / name).chmod(0o755)
    surroundings = {"PATH": str(tmp_path), "TESTS": for_tests, "SUDO_STATUS": str(status)}
    words = [tmp_path / "bash", tmp_path / "tools" / "setup.sh"]
    done = subprocess.run(words, env=surroundings, capture_output=True, text=True, check=False)
    assert done.returncode == 3
    assert said in done.stderr
    assert ("lists of packages may be old" in done.stdout) == (status == 100)
    asked = (tmp_path / "asked").read_text(encoding="utf-8")
    assert "gcc-avr" in asked
    assert ("cppcheck" in asked) == bool(for_tests)
