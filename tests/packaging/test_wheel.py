"""The wheel holds what the tree holds, and works where there is no compiler."""

import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest
from platformio.dependencies import get_core_dependencies

ROOT = Path(__file__).parents[2]
PACKAGES = ("cli", "generator", "sim", "spec", "templates")
NEEDED = ("pyproject.toml", "README.md", "LICENSE", "LICENSES")


def ran(words: list[str | Path], **given: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(words, capture_output=True, text=True, check=False, **given)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from a copy: building leaves files in the tree."""
    copy = tmp_path_factory.mktemp("tree")
    for name in (*PACKAGES, *NEEDED):
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(ROOT / name, copy)
    words = [sys.executable, "-m", "build", "--no-isolation", "--outdir", copy / "dist", copy]
    built = ran(words)
    assert built.returncode == 0, built.stdout + built.stderr
    (found,) = (copy / "dist").glob("*.whl")
    return found


def test_the_wheel_holds_every_file_of_the_packages_and_no_other(wheel: Path) -> None:
    """And both licences."""
    names = set(zipfile.ZipFile(wheel).namelist())
    packed = {name for name in names if ".dist-info/" not in name}
    tree = {
        f"heatwright/{path.relative_to(ROOT).as_posix()}"
        for package in PACKAGES
        for path in (ROOT / package).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert tree - packed == set(), "in the tree and not in the wheel: see pyproject.toml"
    assert packed - tree == set(), "in the wheel and not in the tree"
    held = {name.split("/licenses/")[1] for name in names if "/licenses/" in name}
    assert held == {"LICENSE", "LICENSES/MIT-0.txt"}


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel in a virtual environment of its own, which borrows the libraries of this one."""
    home = tmp_path_factory.mktemp("installed")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", home], check=True)
    python = home / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--python", python, "--disable-pip-version-check"]
    subprocess.run([*pip, "install", "--quiet", "--no-deps", "--no-index", wheel], check=True)
    site = home / Path(sysconfig.get_path("purelib")).relative_to(sys.prefix)
    (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return home


@pytest.fixture
def run(installed: Path, tmp_path: Path) -> Callable[[str], subprocess.CompletedProcess[str]]:
    """Run a command of the installed wheel with nothing on the PATH: no compiler, no PlatformIO."""
    shutil.copy(ROOT / "spec" / "examples" / "chamber.yaml", tmp_path)
    outside = {"HEATWRIGHT_PLATFORMIO": "offline", "HOME": str(tmp_path)}
    outside |= {"LANG": "C.UTF-8", "PATH": "/nonexistent"}

    def run(line: str) -> subprocess.CompletedProcess[str]:
        program, *words = shlex.split(line)
        return ran([installed / "bin" / program, *words], cwd=tmp_path, env=outside)

    return run


def test_it_is_the_wheel_that_is_tested(run: Any, installed: Path) -> None:
    asked = run("python -c 'import heatwright.spec as s; print(s.__file__)'")
    assert asked.stdout.startswith(str(installed)), asked.stderr


def test_check_and_generate_need_no_compiler(run: Any, tmp_path: Path) -> None:
    for line in ("check chamber.yaml", "generate chamber.yaml -o firmware"):
        done = run(f"heatwright {line}")
        assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "firmware" / "platformio.ini").is_file()


def test_build_without_a_compiler_is_one_line_with_the_remedy(run: Any) -> None:
    built = run("heatwright build chamber.yaml")
    assert built.returncode == 3, built.stdout + built.stderr
    assert "sudo apt-get install gcc-avr" in built.stderr


def test_the_readme_calls_the_command_where_setup_puts_it() -> None:
    first_screen = (ROOT / "README.md").read_text(encoding="utf-8").split("\n## ")[0]
    assert "The command is then `.venv/bin/heatwright`" in first_screen
    done = ran([Path(sysconfig.get_path("scripts")) / "heatwright", "--help"])
    assert (done.returncode, done.stdout.startswith("Usage: heatwright")) == (0, True)


def test_scons_is_the_one_that_platformio_asks_for() -> None:
    # PlatformIO writes SCons 4.11.1 as 4.41101.0.
    asked = get_core_dependencies()["tool-scons"]
    major, minor, patch = map(int, version("scons").split("."))
    assert re.fullmatch(rf"~{major}\.{major}{minor:02}{patch:02}\.\d+", asked)


# ---- tools/setup.sh: what it asks for, and what it says when it does not get it ----

FAKES = {
    "id": "echo 1000", "apt-get": "", "python3": f'exec {sys.executable} "$@"',
    "sudo": 'echo "$*" >>asked; exit $STATUS',
}  # fmt: skip
REFUSED = "not installed, as root was not granted; as root: apt-get install gcc-avr"
OFFLINE = "failed: sudo apt-get update"


@pytest.mark.parametrize(("tests", "status", "said"), [("", 1, REFUSED), ("1", 100, OFFLINE)])
def test_it_asks_for_what_is_needed(tests: str, status: int, said: str, tmp_path: Path) -> None:
    (tmp_path / "tools").mkdir()
    shutil.copy(ROOT / "tools" / "setup.sh", tmp_path / "tools")
    for name in ("bash", "dirname", "mkdir", "tail"):
        (tmp_path / name).symlink_to(shutil.which(name) or name)
    for name, text in FAKES.items():
        (tmp_path / name).write_text(f"#!{tmp_path}/bash\n{text}\n", encoding="utf-8")
        (tmp_path / name).chmod(0o755)
    given = {"PATH": str(tmp_path), "TESTS": tests, "STATUS": str(status)}
    done = ran([tmp_path / "tools" / "setup.sh"], env=given)
    assert (done.returncode, said in done.stderr) == (3, True)
    assert ("lists of packages may be old" in done.stdout) == (status == 100)
    asked = (tmp_path / "asked").read_text(encoding="utf-8")
    assert ("gcc-avr" in asked, "cppcheck" in asked) == (True, bool(tests))
