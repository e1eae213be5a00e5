"""Whatever a spec says compiles, and each kind of the language is in all layers."""

import re
import shutil
from collections import Counter
from itertools import islice, product
from pathlib import Path
from random import Random
from typing import Any

import pytest
from jinja2 import Environment, FunctionLoader, StrictUndefined, UndefinedError, nodes
from rig.bad_specs import cases
from rig.controllers import Drawn, attempts, drawings
from rig.firmware import EXAMPLES, ROOT, changed, controller_of, example, files_of, finished, whole
from suite import SEED, amount

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.plan import File, Plan
from heatwright.generator.plan.core import WATCHDOG_NAMES
from heatwright.generator.render import _load, names
from heatwright.generator.stack import worst_stack
from heatwright.generator.toolchain.build import ANY_SIZE
from heatwright.generator.toolchain.result import sizes
from heatwright.sim.bench import bench
from heatwright.sim.binary.elf import Elf
from heatwright.sim.device import AvrDevice
from heatwright.sim.replay import replay_all
from heatwright.spec import BOARDS, Algorithm, Interface, Output, Sensor, SpecError, kinds
from heatwright.spec.checks.board.memory import Least, fits, least
from heatwright.spec.controller import WATCHDOG_S, Controller
from heatwright.spec.names import LONGEST_NAME

TEMPLATES = ROOT / "templates"
LARGE_FLASH = 100_000  # bytes; no drawn firmware takes that much
CODE = (".c", ".h")
FOLDERS = {"sensors": Sensor, "outputs": Output, "algorithms": Algorithm, "interfaces": Interface}
KINDS = [(folder, kind) for folder, union in FOLDERS.items() for kind in kinds(union)]


def test_most_of_what_is_drawn_is_accepted() -> None:
    """And no reason keeps much out: what is refused again and again would never be tried."""
    count = amount("drawn_attempts")
    found = attempts(count)
    assert sum(isinstance(each, Drawn) for each in found) >= 0.8 * count
    reasons: Counter[str] = Counter()
    for each in found:
        if isinstance(each, SpecError):
            reasons.update({re.sub(r"[-\d.]+", "#", problem.reason) for problem in each.problems})
    assert [each for each in reasons.most_common() if each[1] > 0.05 * count + 1] == []


class Noting(Environment):
    """Tells of each condition, wherever one stands in a template, whether it was true."""

    def __init__(self) -> None:
        loader = FunctionLoader(self._noted_text)  # and the rest as the generator's own
        super().__init__(loader=loader, undefined=StrictUndefined, trim_blocks=True)
        self.loaded: set[str] = set()  # all templates in use: what these include or extend, too
        self.places: set[str] = set()  # template and line, for each condition
        self.seen: set[tuple[str, bool]] = set()
        self.globals["noted"] = self._noted

    @property
    def unseen(self) -> set[tuple[str, bool]]:
        """Values that no condition has had yet."""
        return set(product(self.places, (True, False))) - self.seen

    def _noted_text(self, template: str) -> str:
        self.loaded.add(template)
        return _load(template)

    def _noted(self, place: str, value: Any) -> Any:
        self.seen.add((place, bool(value)))
        return value

    def _parse(self, source: str, name: str | None, filename: str | None) -> nodes.Template:
        tree = super()._parse(source, name, filename)
        asked = [each for each in tree.find_all((nodes.If, nodes.CondExpr, nodes.For)) if each.test]
        for number, each in enumerate(asked):
            line = source.splitlines()[each.lineno - 1]
            place = f"{name}:{each.lineno}:{number} {line.strip()}"
            self.places.add(place)
            known = nodes.Name("noted", "load")
            each.test = nodes.Call(known, [nodes.Const(place), each.test], [], None, None)
        return tree


def test_every_kind_template_and_condition_is_drawn() -> None:
    """Each condition of each template, wherever it stands, has both values."""
    noting, found = Noting(), set[str]()
    files = [path for path in TEMPLATES.glob("*/**/*") if path.suffix in {*CODE, ".j2", ".py"}]
    templates = {path.relative_to(TEMPLATES).as_posix() for path in files}
    every = {*BOARDS, *(kind for _, kind in KINDS)}
    random = Random(f"conditions {SEED}")  # noqa: S311 - no secret
    for each in islice(drawings(random, seldom=3), amount("drawn_planned")):
        for file in plan_firmware(each.spec).files:
            noting.get_template(file.template).render(names(file.told))
        found |= kinds_in(each.spec.controller)
        if noting.loaded == templates and not noting.unseen and found == every:
            break  # more of them would show no more
    assert (noting.loaded, noting.unseen) == (templates, set())
    assert found == every


def kinds_in(controller: Controller) -> set[str]:
    loops = controller.loops.values()
    parts = [*controller.sensors.values(), *controller.outputs.values(), *controller.interfaces]
    kinds_of_parts = {each.kind for each in (*parts, *(loop.algorithm for loop in loops))}
    return kinds_of_parts | {controller.board.name}


@pytest.mark.parametrize("number", range(amount("drawn_compiled")))
def test_any_compiles_and_runs(number: int) -> None:
    random = Random(f"compiled {SEED} {number}")  # noqa: S311 - no secret
    assert_it_compiles_and_runs(next(drawings(random)))


def assert_it_compiles_and_runs(drawn: Drawn) -> None:
    files = files_of(drawn.text)
    code = Counter(re.findall(r"\w+", "".join(files[path] for path in files if path[-2:] in CODE)))
    constants = re.findall(r"^#define (\w+) .+$", files["src/config.h"], re.MULTILINE)
    assert [name for name in constants if code[name] < 2] == []
    controller = drawn.spec.controller
    elf = whole(drawn.text, *project_flags(files["platformio.ini"]), ANY_SIZE)
    taken = Least(sizes(elf.path)[0], sizes(elf.path)[1] + worst_stack(elf.path).total)
    assert taken.flash < LARGE_FLASH, drawn
    bounds = zip(least(controller), taken, strict=True)
    assert all(bound <= each for bound, each in bounds), drawn  # no less is warned of or refused
    if controller.simulation is not None and fits(taken, controller.board):
        assert_it_equals_the_reference(controller, elf, drawn)


def assert_it_equals_the_reference(controller: Controller, elf: Elf, drawn: Drawn) -> None:
    logs = bench(controller, AvrDevice(controller, elf)).steps
    logs = {name: log for name, log in logs.items() if len(log)}  # a period may be long
    for loop, result in replay_all(controller, logs).items():
        assert (result.mismatches, result.segments) == (0, 1), (loop, result.first, drawn)
        assert result.restored == (), (loop, drawn)


def project_flags(ini: str) -> list[str]:
    (words,) = re.findall(r"^build_flags =\n((?: +.*\n)+)", ini, re.MULTILINE)
    flags: list[str] = words.split()
    assert {"-Werror", "-Wpedantic", "-Wconversion", "-std=c11"} <= set(flags)
    return flags


def test_the_folders_hold_kinds_alone_and_the_examples_use_every_one() -> None:
    for folder, union in FOLDERS.items():
        shared = {"__init__", "common", "autotune"}
        room = ROOT / "generator" / "plan" / folder
        plans = {path.stem for path in (*room.glob("*.py"), *room.glob("*/__init__.py"))}
        plans |= {path.parent.name for path in room.glob("*/__init__.py")}
        assert plans - shared == set(kinds(union))
    texts = [path.read_text("utf-8") for path in EXAMPLES.glob("*.yaml")]
    used = {kind for text in texts for kind in re.findall(r"\bkind: (\w+)", text)}
    assert {kind for _, kind in KINDS} <= used


@pytest.mark.parametrize(("folder", "kind"), KINDS)
def test_a_bad_spec_is_about_it(folder: str, kind: str) -> None:
    """One of its keys, or it by name, is objected to; that it occurs would show nothing."""
    own = {field.alias or name for name, field in kinds(FOLDERS[folder])[kind].model_fields.items()}
    section = "loops" if folder == "algorithms" else folder
    for case in cases().values():
        text = case.text.decode(errors="replace")
        messages = [line for line in case.messages if f" {section}" in line]
        objects = any(f".{key}:" in line or kind in line for line in messages for key in own)
        if f"kind: {kind}" in text and objects:
            return
    pytest.fail(f"nothing in tests/bad_specs objects to a key of {kind}")


def test_every_watchdog_period_has_its_name_in_avr_libc() -> None:
    assert set(WATCHDOG_NAMES) == set(WATCHDOG_S)
    header = Path("/usr/lib/avr/include/avr/wdt.h").read_text("utf-8", errors="replace")
    for name in WATCHDOG_NAMES.values():
        assert re.search(rf"#define\s+WDTO_{name}\b", header)


PLAIN = changed("chamber").partition("simulation:")[0]


def test_an_undefined_name_is_an_error() -> None:
    file = File("src/clock.c", "core/clock.c.j2", {"tick_ms": 10})
    with pytest.raises(UndefinedError, match="'timer' is undefined"):
        render(Plan("name", "banner", (file,)))


@pytest.mark.parametrize("name", ["ticks", "fault", "i_2", "w" * LONGEST_NAME])
def test_a_name_may_be_any_word_of_the_firmware(name: str) -> None:
    """One name for sensor, output and loop at once, and one the firmware uses itself."""
    text = changed(PLAIN, ("maximum: 70 °C}", "maximum: 70 °C, stored: true}"))
    whole(re.sub(r"\bair\b|(?<=: )heater|heater(?=: {)", name, text))


@pytest.mark.parametrize("clock_mhz", [8, 14.7456, 20])
def test_another_crystal(clock_mhz: float) -> None:
    """PlatformIO is told of it, and no other clock compiles: every time would be wrong."""
    text = changed("chamber", ("board: uno", f"board: uno\n  clock: {clock_mhz} MHz"))
    text = text.partition("interfaces:")[0]
    clock_hz = controller_of(text).board.clock_hz
    assert "f_cpu" not in files_of("chamber")["platformio.ini"]
    assert clock_hz == round(clock_mhz * 1e6)
    assert f"\nboard_build.f_cpu = {clock_hz}L\n" in files_of(text)["platformio.ini"]
    whole(text)
    with pytest.raises(AssertionError, match=f"generated for a {clock_mhz:g} MHz clock"):
        whole(text, "-UF_CPU", "-DF_CPU=16000000UL")
    with pytest.raises(AssertionError, match="choose that board"):
        whole(text, "-U__AVR_ATmega328P__")


def test_as_many_periods_as_can_be_counted_are_taken_as_the_file_says_them() -> None:
    """0.83 · 255 is a little less than 211.65 in binary, and 70.2 − 10.3 than 59.9."""
    text = changed(
        PLAIN, ("period: 1 s", "period: 0.83 s"), ("stale_after: 5 s", "stale_after: 211.65 s"),
        ("minimum: 10 °C, maximum: 70 °C", "minimum: 10.3 °C, maximum: 70.2 °C"),
        ("step: 10 K", "step: 59.9 K"),
    )  # fmt: skip
    assert controller_of(text).loops["air"].protection.stale_after_s == 211.65
    assert "STALE_STEPS 255u" in files_of(text)["src/config.h"]


def test_two_converters_with_registers_share_no_name() -> None:
    wires = "chip_select: D{0}0, clock: D{0}1, data_in: D{0}2, data_out: D{0}3"
    air, wall = (f"{{kind: max31856, {wires.format(place)}}}" for place in (3, 4))
    settings = "period: 1 s, setpoint: {initial: 20 °C, minimum: 10 °C, maximum: 70 °C}"
    loop = f"{{sensor: wall, heater: other, {settings}, algorithm: {{kind: on_off}}}}"
    whole(changed(
        PLAIN, ("{kind: ds18b20, pin: A1, resolution: 12 bit}", f"{air}\n  wall: {wall}"),
        ("\nsafety:", f"  wall: {loop}\nsafety:"), ("board: uno", "board: mega2560"),
        ("outputs:", "outputs:\n  other: {kind: digital, pin: D22, power: 9 W}"),
    ))  # fmt: skip


IDE = Path("/usr/share/arduino/hardware/arduino/avr")  # where Debian's arduino-core-avr puts it

SLOW = {"-flto", "-fno-fat-lto-objects", "-fuse-linker-plugin"}
"""Link-time optimisation, which older IDEs do without."""


def flags(language: str, lto: bool) -> list[str]:
    """Return what platform.txt gives the compiler; every warning an error."""
    text = (IDE / "platform.txt").read_text()
    (found,) = re.findall(rf"^compiler\.{re.escape(language)}\.flags=(.*)$", text, re.MULTILINE)
    words: list[str] = found.replace("{compiler.warning_flags}", "-Wall -Wextra").split()
    return [word for word in words if lto or word not in SLOW]


def run(*command: str | Path, cwd: Path) -> str:
    done = finished(command, cwd=cwd)
    assert done.returncode == 0, done.stderr
    return done.stdout


def core(folder: Path, lto: bool, where: list[str]) -> Path:
    folder.mkdir()
    for language, compiler in (("c", "avr-gcc"), ("cpp", "avr-g++")):
        chosen = sorted((IDE / "cores" / "arduino").glob(f"*.{language}"))
        # gcc 5.4 keeps this one from C++; the IDE's own compiler is newer.
        words = [*flags(language, lto), "-w", "-DDECIMAL_DIG=__DECIMAL_DIG__"]
        run(compiler, *words, *where, *chosen, cwd=folder)
    run("avr-gcc-ar", "rcs", "core.a", *sorted(folder.glob("*.o")), cwd=folder)
    return folder / "core.a"


@pytest.mark.parametrize("lto", [True, False], ids=["lto", "plain"])
def test_the_ide_builds_the_chamber(lto: bool, tmp_path: Path) -> None:
    chamber_files = files_of("chamber")
    write(chamber_files, tmp_path / "chamber")
    sources = sorted((tmp_path / "chamber" / "src").glob("*.c"))
    where = [
        "-mmcu=atmega328p", "-DF_CPU=16000000L", "-DARDUINO=10819", "-DARDUINO_AVR_UNO",
        "-DARDUINO_ARCH_AVR", f"-I{IDE}/cores/arduino", f"-I{IDE}/variants/standard",
    ]  # fmt: skip
    archive = core(tmp_path / "core", lto, where)
    # The IDE puts Arduino.h in front of the sketch and compiles it as C++.
    sketch = tmp_path / "chamber.ino.cpp"
    sketch.write_text(f"#include <Arduino.h>\n{chamber_files['chamber.ino']}", encoding="utf-8")
    ours = tmp_path / "objects"
    ours.mkdir()
    run("avr-gcc", *flags("c", lto), "-Werror", *where, *sources, cwd=ours)
    run("avr-g++", *flags("cpp", lto), "-Werror", *where, sketch, cwd=ours)
    run(
        "avr-gcc", *flags("c.elf", lto), "-Werror", "-mmcu=atmega328p", "-o", "chamber.elf",
        *sorted(ours.glob("*.o")), archive, "-lm", "-Wl,-Map=chamber.map", cwd=tmp_path,
    )  # fmt: skip
    assert "core.a(" not in (tmp_path / "chamber.map").read_text().partition("Allocating")[0]
    listing = run("avr-objdump", "-d", "chamber.elf", cwd=tmp_path)
    # The reset leads to heaters_off: D3 = PD3 low and driven before there is a stack.
    (first,) = re.findall(r"^ +0:\t(?:\w\w )+\s*jmp\t0x(\w+)", listing, re.MULTILINE)
    start = rf"^0*{first} <heaters_off>:\n(.*\n)(.*\n)"
    ((low, driven),) = re.findall(start, listing, re.MULTILINE)
    assert "cbi\t0x0b, 3" in low
    assert "sbi\t0x0a, 3" in driven


CPPCHECK = [
    "cppcheck", "--quiet", "--enable=warning,performance,portability", "--inconclusive",
    "--std=c11", "--platform=avr8", "--library=avr", "--error-exitcode=1",
]  # fmt: skip

CHECKED = ("chamber", "fabricator", "dryer", "kiln", "kiln_uno")


@pytest.mark.parametrize("case", [*CHECKED, *range(amount("drawn_for_cppcheck"))])
def test_nothing_is_found(case: str | int, tmp_path: Path) -> None:
    random = Random(f"cppcheck {SEED} {case}")  # noqa: S311 - no secret
    spec = example(case) if isinstance(case, str) else next(drawings(random)).spec
    board = spec.controller.board
    write(render(plan_firmware(spec)), tmp_path)
    assert shutil.which("cppcheck"), "sudo apt-get install cppcheck"
    words = [*CPPCHECK, f"-D{board.macro}", f"-DF_CPU={board.clock_hz}UL", "src"]
    done = finished(words, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
