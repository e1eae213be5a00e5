"""The wheel holds what the tree holds, and works where there is no compiler."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from platformio.dependencies import get_core_dependencies
from rig.firmware import ROOT, finished

PACKAGES = ("cli", "generator", "sim", "spec", "templates")
NEEDED = ("pyproject.toml", "README.md", "LICENSE", "LICENSES")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from a copy: building leaves files in the tree."""
    copy = tmp_path_factory.mktemp("tree")
    for name in (*PACKAGES, *NEEDED):
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(ROOT / name, copy)
    return wheel_of(copy)


def wheel_of(folder: Path) -> Path:
    words = [sys.executable, "-m", "build", "--no-isolation", "--outdir", folder / "dist", folder]
    built = finished(words)
    assert built.returncode == 0, built.stdout + built.stderr
    (found,) = (folder / "dist").glob("*.whl")
    return found


def test_the_wheel_holds_every_file_of_the_packages_and_no_other(wheel: Path) -> None:
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
    assert held == {"LICENSE", "LICENSES/MIT-0.txt", "LICENSES/MIT-uPlot.txt"}


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return environment(tmp_path_factory.mktemp("installed"), wheel)


def environment(home: Path, *wheels: Path) -> Path:
    """Wheels in a virtual environment of their own, which borrows the libraries of this one."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", home], check=True)
    python = home / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--python", python, "--disable-pip-version-check"]
    subprocess.run([*pip, "install", "--quiet", "--no-deps", "--no-index", *wheels], check=True)
    (site_of(home) / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return home


def site_of(home: Path) -> Path:
    return home / Path(sysconfig.get_path("purelib")).relative_to(sys.prefix)


@pytest.fixture
def run(installed: Path, tmp_path: Path) -> Callable[[str], subprocess.CompletedProcess[str]]:
    """Run a command of the installed wheel with nothing on the PATH: no compiler, no PlatformIO."""
    shutil.copy(ROOT / "spec" / "examples" / "chamber.yaml", tmp_path)
    outside = {"HEATWRIGHT_PLATFORMIO": "offline", "HOME": str(tmp_path)}
    outside |= {"LANG": "C.UTF-8", "PATH": "/nonexistent"}

    def run(line: str) -> subprocess.CompletedProcess[str]:
        program, *words = shlex.split(line)
        return finished([installed / "bin" / program, *words], cwd=tmp_path, env=outside)

    return run


def test_it_is_the_wheel_that_is_tested(run: Any, installed: Path) -> None:
    asked = run("python -c 'import heatwright.spec as s; print(s.__file__)'")
    assert asked.stdout.startswith(str(installed)), asked.stderr


def test_init_check_and_generate_need_no_compiler(run: Any, tmp_path: Path) -> None:
    for line in ("init my.yaml --machine kiln", "check my.yaml", "generate my.yaml -o firmware"):
        done = run(f"heatwright {line}")
        assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "firmware" / "platformio.ini").is_file()


@pytest.mark.parametrize("command", ["build", "simulate", "verify", "upload"])
def test_without_a_compiler_it_is_one_line_with_the_remedy(run: Any, command: str) -> None:
    done = run(f"heatwright {command} chamber.yaml")
    assert done.returncode == 3, done.stdout + done.stderr
    said = done.stderr.splitlines()
    assert [line for line in said if "sudo apt-get install " in line] == said[-1:]


@dataclass(frozen=True)
class Outside:
    role: str
    kind: str
    model: str
    driver: str  # a file of its firmware
    said: str  # words of that file
    faults: frozenset[str]  # some that `verify` must try
    pieces: Mapping[str, str]  # its files, each with what is told when it is missing

    @property
    def folder(self) -> Path:
        return ROOT / "examples" / self.kind

    @property
    def package(self) -> str:
        return f"heatwright_{self.kind}"


MAX31865 = Outside(
    "sensor", "max31865", "Max31865", "sensor_air.c", "MAX31865, CS D10",
    frozenset({"element_broken", "element_shorted", "orders_shorted_to_supply"}),
    {
        "plan.py": "the plan of its firmware, which must define plan",
        "simulated.py": "the simulation at its pins, which must define attach",
        "reference.py": "the reference model, which must define IdealSensor and converter",
        "faults.py": "the faults, which must define cut and faults and mend",
        "example.yaml": "a spec that uses max31865", "templates/max31865.c.j2": "",
    },
)  # fmt: skip
I2C_LCD = Outside(
    "interface", "i2c_lcd", "I2cLcd", "i2c_lcd_bus.c", "SDA A4 = PC4, SCL A5 = PC5",
    frozenset({"power_cut", "reset_button"}),
    {
        "plan.py": "the plan of its firmware, which must define plan",
        "simulated.py": "the simulation at its pins, which must define attach",
        "seat.py": "the place at the bench, which must define take",
        "example.yaml": "a spec that uses i2c_lcd", "templates/i2c_lcd_bus.c.j2": "",
    },
)  # fmt: skip
OUTSIDE = (I2C_LCD, MAX31865)
each_outside = pytest.mark.parametrize("outside", OUTSIDE, ids=lambda each: each.kind)
PACKAGE = MAX31865.package


@pytest.fixture(scope="module")
def beside(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    copies = tmp_path_factory.mktemp("outside")
    without = shutil.ignore_patterns("__pycache__", "*.egg-info")
    for each in OUTSIDE:
        shutil.copytree(each.folder, copies / each.kind, ignore=without)
    wheels = [wheel_of(copies / each.kind) for each in OUTSIDE]
    return environment(tmp_path_factory.mktemp("beside"), wheel, *wheels)


def heatwright(home: Path, *words: str, **given: Any) -> subprocess.CompletedProcess[str]:
    return finished([home / "bin" / "heatwright", *words], **given)


def test_the_packages_beside_it_bring_kinds(beside: Path) -> None:
    listed = json.loads(heatwright(beside, "kinds", "--json").stdout)
    others = [each for each in listed["kinds"] if each["package"] != "heatwright"]
    due = [
        {"role": each.role, "kind": each.kind, "package": each.package, "lacks": []}
        for each in OUTSIDE
    ]
    assert sorted(others, key=lambda each: str(each["kind"])) == due
    assert listed["misnamed"] == []


@each_outside
def test_its_example_fits_the_schema_and_becomes_a_firmware(
    beside: Path, tmp_path: Path, outside: Outside
) -> None:
    schema = json.loads(heatwright(beside, "schema").stdout)
    assert outside.model in schema["$defs"]
    example = site_of(beside) / outside.package / "example.yaml"
    jsonschema.Draft202012Validator(schema).validate(yaml.safe_load(example.read_text("utf-8")))
    for words in (("check",), ("generate", "-o", "firmware"), ("generate", "--check")):
        done = heatwright(beside, *words, str(example), cwd=tmp_path)
        assert done.returncode == (words[-1] == "--check"), done.stdout + done.stderr
    assert outside.said in (tmp_path / "firmware" / "src" / outside.driver).read_text("utf-8")


@each_outside
def test_its_firmware_verifies_and_its_own_tests_pass(
    beside: Path, tmp_path: Path, outside: Outside
) -> None:
    """All that heatwright proves of its own, and no line of heatwright is changed for it."""
    example = site_of(beside) / outside.package / "example.yaml"
    done = heatwright(beside, "verify", str(example), "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert outside.faults <= {each["fault"] for each in json.loads(done.stdout)["faults"]}
    tests = outside.folder / "tests"
    words = [beside / "bin" / "python", "-m", "pytest", "-q", tests, "--rootdir", "."]
    own = finished([*words, "-p", "no:cacheprovider"], cwd=tmp_path)
    assert own.returncode == 0, own.stdout


@pytest.mark.parametrize(
    ("outside", "piece"),
    [(each, piece) for each in OUTSIDE for piece in each.pieces],
    ids=lambda each: each.kind if isinstance(each, Outside) else each,
)
def test_each_missing_piece_is_told_with_its_file(
    beside: Path, outside: Outside, piece: str
) -> None:
    file = site_of(beside) / outside.package / piece
    away = file.rename(file.with_suffix(".away"))
    try:
        told = heatwright(beside, "kinds")
    finally:
        away.rename(file)
    assert told.returncode == 1
    assert f"{outside.package}/{piece}" in told.stdout
    assert outside.pieces[piece] in told.stdout


@pytest.mark.parametrize(
    ("piece", "command", "what"),
    [
        ("reference", "check", "reference model"),
        ("simulated", "simulate", "simulation at its pins"),
    ],
)
def test_whoever_meets_a_missing_piece_is_told(
    beside: Path, tmp_path: Path, piece: str, command: str, what: str
) -> None:
    file = site_of(beside) / PACKAGE / f"{piece}.py"
    away = file.rename(file.with_suffix(".away"))
    try:
        example = str(site_of(beside) / PACKAGE / "example.yaml")
        used = heatwright(beside, command, example, cwd=tmp_path)
    finally:
        away.rename(file)
    assert used.returncode == 2
    said = f"The sensor kind max31865 has no {what}: write {PACKAGE}/{piece}.py, which must define"
    assert said in used.stderr


def test_what_a_package_says_wrong_is_told(beside: Path, tmp_path: Path) -> None:
    """It must not stop the others; whoever asks for its kind hears why there is none."""
    site = tmp_path / "site"
    points = {
        "sensor.broken": "broken.model:Broken", "sensor.rtd": f"{PACKAGE}.model:Max31865",
        "sensor.named": f"{PACKAGE}.model:Max31865", "sensors.x": "y:Z",
    }  # fmt: skip
    (site / "wrong-1.dist-info").mkdir(parents=True)
    text = "".join(f"{name} = {place}\n" for name, place in points.items())
    said = f"[heatwright.kinds]\n{text}\n[other]\nsensor.y = z:Y\n"
    (site / "wrong-1.dist-info" / "entry_points.txt").write_text(said)
    (site / "broken").mkdir()
    (site / "broken" / "model.py").write_text("import nothing_there\n")
    given = {"env": {**os.environ, "PYTHONPATH": str(site)}}
    told = heatwright(beside, "kinds", **given)
    assert told.returncode == 1
    for line in (
        "broken.model:Broken cannot be imported (No module named 'nothing_there')",
        'pyproject.toml: "sensors.x" = "y:Z" begins with none of sensor, output, algorithm',
        "Max31865 is of the kind max31865, but its entry point names the kind named",
        f"{PACKAGE} provides the sensor kind rtd, which heatwright has itself",
    ):
        assert line in told.stdout
    spec = tmp_path / "chamber.yaml"
    chamber = (ROOT / "spec" / "examples" / "chamber.yaml").read_text("utf-8")
    spec.write_text(chamber, "utf-8")
    assert heatwright(beside, "check", "--quick", str(spec), **given).returncode == 0
    spec.write_text(chamber.replace("kind: ds18b20", "kind: broken"), "utf-8")
    refused = heatwright(beside, "check", "--quick", str(spec), **given)
    assert refused.returncode == 2
    assert "'broken' is not usable: broken.model:Broken cannot be imported" in refused.stdout


def test_stubs_are_a_package_that_tells_what_is_to_be_written(beside: Path, tmp_path: Path) -> None:
    assert heatwright(beside, "new", "sensor", "ds18b20", cwd=tmp_path).returncode == 2
    assert heatwright(beside, "new", "sensor", "Probe", cwd=tmp_path).returncode == 2
    made = heatwright(beside, "new", "sensor", "my_probe", "--json", cwd=tmp_path)
    listed = json.loads(made.stdout)
    folder = tmp_path / listed["folder"]
    there = [path for path in folder.rglob("*") if path.is_file()]
    assert sorted(listed["files"]) == sorted(each.relative_to(folder).as_posix() for each in there)
    assert heatwright(beside, "new", "sensor", "my_probe", cwd=tmp_path).returncode == 2
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    site = tmp_path / "site"
    options = ["--no-deps", "--no-index", "--no-build-isolation", "--target", site]
    installed = finished([*pip, *options, folder])
    assert installed.returncode == 0, installed.stderr
    given = {"env": {**os.environ, "PYTHONPATH": str(site)}, "cwd": tmp_path}
    told = heatwright(beside, "kinds", **given)
    assert told.returncode == 1
    lines = [line for line in told.stdout.splitlines() if line.endswith("is still to be written")]
    for part in ("model.py", "plan.py", "simulated.py", "reference.py", "faults.py", "templates/"):
        assert any(line.startswith(f"heatwright_my_probe/{part}") for line in lines), part
    used = heatwright(beside, "check", str(folder / "heatwright_my_probe/example.yaml"), **given)
    assert used.returncode == 2
    assert "The package heatwright_my_probe has failed (NotImplementedError)" in used.stderr


def test_the_readme_calls_the_command_where_setup_puts_it() -> None:
    first_screen = (ROOT / "README.md").read_text(encoding="utf-8").split("\n## ")[0]
    assert "The command is then `.venv/bin/heatwright`" in first_screen
    done = finished([Path(sysconfig.get_path("scripts")) / "heatwright", "--help"])
    assert (done.returncode, done.stdout.startswith("Usage: heatwright")) == (0, True)


def test_scons_is_the_one_that_platformio_asks_for() -> None:
    # PlatformIO writes SCons 4.11.1 as 4.41101.0.
    asked = get_core_dependencies()["tool-scons"]
    major, minor, patch = map(int, version("scons").split("."))
    assert re.fullmatch(rf"~{major}\.{major}{minor:02}{patch:02}\.\d+", asked)


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
    done = finished([tmp_path / "tools" / "setup.sh"], env=given)
    assert (done.returncode, said in done.stderr) == (3, True)
    assert ("lists of packages may be old" in done.stdout) == (status == 100)
    asked = (tmp_path / "asked").read_text(encoding="utf-8")
    assert ("gcc-avr" in asked, "cppcheck" in asked) == (True, bool(tests))
