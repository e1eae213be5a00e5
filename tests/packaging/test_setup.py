"""What tools/setup.sh asks for, and what it says when it does not get it."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

FAKES = {
    "id": "echo 1000", "apt-get": "", "python3": f'exec {sys.executable} "$@"',
    "sudo": 'echo "$*" >>asked; exit $STATUS',
}  # fmt: skip
REFUSED = "not installed, as root was not granted; as root: apt-get install gcc-avr"
OFFLINE = "failed: sudo apt-get update"


@pytest.mark.parametrize(("tests", "status", "said"), [("", 1, REFUSED), ("1", 100, OFFLINE)])
def test_it_asks_for_what_is_needed(tests: str, status: int, said: str, tmp_path: Path) -> None:
    (tmp_path / "tools").mkdir()
    shutil.copy(Path(__file__).parents[2] / "tools" / "setup.sh", tmp_path / "tools")
    for name in ("bash", "dirname", "mkdir", "tail"):
        (tmp_path / name).symlink_to(shutil.which(name) or name)
    for name, text in FAKES.items():
        (tmp_path / name).write_text(f"#!{tmp_path}/bash\n{text}\n", encoding="utf-8")
        (tmp_path / name).chmod(0o755)
    given = {"PATH": str(tmp_path), "TESTS": tests, "STATUS": str(status)}
    words = [tmp_path / "tools" / "setup.sh"]
    done = subprocess.run(words, env=given, capture_output=True, text=True, check=False)
    assert (done.returncode, said in done.stderr) == (3, True)
    assert ("lists of packages may be old" in done.stdout) == (status == 100)
    asked = (tmp_path / "asked").read_text(encoding="utf-8")
    assert ("gcc-avr" in asked, "cppcheck" in asked) == (True, bool(tests))
