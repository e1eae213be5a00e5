"""A project becomes a binary, here without a registry, and the figures are those of the binary."""

import os
import re
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from rig.firmware import finished

from heatwright.generator.toolchain import BuildFailed, ToolMissing, build
from heatwright.generator.toolchain.build import given
from heatwright.generator.toolchain.cache import KEPT_S, forget_old
from heatwright.generator.toolchain.offline import core_dir
from heatwright.spec.boards import BOARDS, Board
from heatwright.spec.loading.user_cache import cache_dir

Project = Callable[..., Path]

BUILD = (
    "import sys; from pathlib import Path; from heatwright.generator.toolchain import build;"
    "print(build(Path(sys.argv[1]), progress=lambda line: print(line, flush=True)).elf)"
)


# The smallest program that has all that a build reports: code, both kinds of variables, calls, an
# interrupt and a library routine.
SMALLEST = {
    "platformio.ini": """
        [env:uno]
        platform = atmelavr
        board = uno
        build_flags = -g -Wextra -Werror
        """,
    "src/level.h": "float level(float last);",
    "src/level.c": """
        #include "level.h"
        #include <avr/io.h>
        float level(float last) { return last + 0.25f * ((float)PINB - last); }
        """,
    "src/main.c": """
        #include <avr/interrupt.h>
        #include <avr/io.h>
        #include "level.h"
        static volatile float mean = 1.5f;
        static volatile uint16_t ticks;
        ISR(TIMER1_OVF_vect) { ticks++; }
        int main(void) { sei(); for (;;) mean = level(mean); }
        """,
}


@pytest.fixture
def project(tmp_path: Path) -> Project:
    def written(
        board: str = "uno", ini: str = "", main: str | None = None, at: str = "project"
    ) -> Path:
        for path, text in SMALLEST.items():
            file = tmp_path / at / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(textwrap.dedent(text).strip() + "\n")
        file = tmp_path / at / "platformio.ini"
        file.write_text(file.read_text().replace("uno", board) + ini)
        if main is not None:
            (tmp_path / at / "src" / "main.c").write_text(main)
        return tmp_path / at

    return written


@pytest.fixture
def fresh_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "heatwright"


@pytest.fixture(autouse=True)
def _no_network(monkeypatch: pytest.MonkeyPatch) -> None:
    """Send whatever asks for a network to a port where nobody listens."""
    for name in ("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")


def contents(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_figures_are_those_of_avr_size(project: Project) -> None:
    result = build(project())
    listed = finished(["avr-size", result.elf], check=True).stdout
    text, data, bss = map(int, listed.splitlines()[1].split()[:3])
    assert (result.flash_bytes, result.ram_bytes, result.ram_bytes) == (text + data, data + bss, 6)
    assert (result.flash_limit, result.ram_limit) == (32768 - 512, 2048)
    assert f"used {result.flash_bytes} bytes from {result.flash_limit} bytes" in result.log
    measured = given(result.elf, BOARDS["uno"])  # as if it came from elsewhere
    assert replace(measured, log=result.log, cached=result.cached) == result


@pytest.mark.parametrize("board", BOARDS.values(), ids=lambda board: board.name)
def test_every_board_builds(board: Board, project: Project) -> None:
    result = build(project(board=board.platformio))
    assert result.flash_limit == board.flash_bytes - board.bootloader_bytes
    assert result.ram_limit == board.ram_bytes


def test_the_clock_and_the_flags_are_the_projects_own(project: Project) -> None:
    checks = "#if F_CPU != 8000000L || !defined(HOT)\n#error no\n#endif\n"
    main = f"{checks}int main(void) {{ for (;;); }}\n"
    build(project(ini=" -DHOT\nboard_build.f_cpu = 8000000L\n", main=main))
    # A flag of the platform can be taken off.
    main = "int main(void) { int never; for (;;); }\n"
    with pytest.raises(BuildFailed, match="unused variable"):
        build(project(main=main))
    build(project(main=main, ini="build_unflags = -Wall\n"))


def test_the_same_project_is_built_once(project: Project, fresh_cache: Path) -> None:
    """Each step of it is told, and the project is left as it was."""
    told: list[str] = []
    folder = project()
    before = contents(folder)
    first = build(folder, progress=told.append)
    assert contents(folder) == before
    assert first.elf.is_relative_to(fresh_cache)
    assert {line.split()[0] for line in told} == {"Compiling", "Linking"}
    assert "Linking uno/firmware.elf" in told
    told.clear()
    again = build(project(at="elsewhere"), progress=told.append)
    assert (first.cached, again.cached, told) == (False, True, [])
    assert (again.elf, again.flash_bytes) == (first.elf, first.flash_bytes)


def test_what_is_damaged_in_the_cache_is_made_again(project: Project, fresh_cache: Path) -> None:
    image = build(project()).elf.read_bytes()
    binary = "builds/*/project/.pio/build/uno/firmware."
    platform = "platformio/*/platforms/atmelavr/platform.json"
    for pattern in (f"{binary}elf", f"{binary}hex", "builds/*/result.json", platform):
        (file,) = fresh_cache.glob(pattern)
        sound = file.read_bytes()
        file.write_bytes(sound[: len(sound) // 2])
        again = build(project())
        assert (again.cached, again.elf.read_bytes()) == (pattern == platform, image)
        assert "result" in pattern or file.read_bytes() == sound  # the record has its log's times
        assert build(project()).cached


def test_a_cache_at_no_absolute_path_is_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    for value in ("", "relative", "./here"):
        monkeypatch.setenv("XDG_CACHE_HOME", value)
        assert cache_dir() == Path.home() / ".cache/heatwright"


def test_another_place_gives_the_same_image(
    project: Project, fresh_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    images = []
    for place in ("here", "there"):
        monkeypatch.setenv("XDG_CACHE_HOME", str(fresh_cache / place))
        image = fresh_cache / "image.hex"
        words = ["avr-objcopy", "-O", "ihex", build(project(at=place)).elf, image]
        subprocess.run(words, check=True)
        images.append(image.read_bytes())
    assert images[0] == images[1]


def test_the_compilers_errors_are_told(project: Project) -> None:
    folder = project(main="int main(void) { return missing(1) }\n")
    with pytest.raises(BuildFailed) as caught:
        build(folder)
    lines = str(caught.value).splitlines()
    assert lines[0] == f"{folder}: PlatformIO could not build it"
    assert any(re.match(r"src/main\.c:1:\d+: error: ", line) for line in lines)
    assert " int main(void) { return missing(1) }" in lines
    assert "heatwright/builds" not in str(caught.value)


REFUSED = {
    "a missing function": (
        {"main": "void absent(void);\nint main(void) { absent(); for (;;); }\n"},
        "undefined reference to `absent'",
    ),
    "an unknown board": ({"board": "teapot"}, "Unknown board ID 'teapot'"),
    "a board without a size": (
        {"ini": "board_upload.maximum_ram_size = 0\n"}, "does not know how much flash and RAM",
    ),
    "too much flash": (
        {"main": "#include <avr/pgmspace.h>\n"
                 "__attribute__((used)) const char big[32600] PROGMEM = {1};\n"
                 "int main(void) { for (int i = 0;; i++) if (pgm_read_byte(big + i)) i++; }\n"},
        "32[67].. bytes of flash, of 32256$",
    ),
    "more variables than the linker takes": (
        {"main": "volatile char b[5000];\nint main(void) { for (;;) b[9]++; }\n"}, "5000 bytes of",
    ),
    "a stack that meets the variables": (
        {"main": "#include <stdint.h>\nstatic volatile uint8_t big[2000];\nint main(void) {\n"
                 "volatile uint8_t frame[60]; for (;;) frame[big[1]] = big[frame[9]]; }\n"},
        r"2000 bytes of variables and 6\d bytes of stack",
    ),
    "an unknown stack": (
        {"main": "int (*volatile f)(void);\nint main(void) { for (;;) f(); }\n"},
        "main calls a function by pointer",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("changes", "reason"), REFUSED.values(), ids=REFUSED)
def test_it_is_told_why_it_does_not_build(
    changes: dict[str, str], reason: str, project: Project
) -> None:
    with pytest.raises(BuildFailed, match=reason):
        build(project(**changes))


def test_no_project_is_told(tmp_path: Path) -> None:
    with pytest.raises(BuildFailed, match=r"platformio\.ini is missing"):
        build(tmp_path)


def test_several_environments_need_a_choice(project: Project) -> None:
    folder = project(ini="\n[env:mega]\nplatform = atmelavr\nboard = megaatmega2560\n")
    with pytest.raises(BuildFailed, match="not mega, uno: set default_envs"):
        build(folder)
    assert build(folder, environment="mega").ram_limit == 8192


@pytest.mark.parametrize(
    ("name", "value", "remedy"),
    [
        ("PATH", "/nonexistent", "sudo apt-get install gcc-avr avr-libc"),
        ("HEATWRIGHT_PLATFORMIO", "sideways", "HEATWRIGHT_PLATFORMIO=sideways"),
    ],
)
def test_a_missing_compiler_is_one_line_with_the_remedy(
    name: str, value: str, remedy: str, project: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HEATWRIGHT_PLATFORMIO", "offline")
    monkeypatch.setenv(name, value)
    with pytest.raises(ToolMissing, match=remedy) as caught:
        build(project())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "settings",
    [
        # A core directory with all that is needed stands for one that PlatformIO filled online.
        {"PLATFORMIO_CORE_DIR": str(core_dir()), "HEATWRIGHT_PLATFORMIO": "online"},
        {"PLATFORMIO_BUILD_FLAGS": "-DNONSENSE -O0", "PLATFORMIO_BUILD_DIR": "elsewhere"},
    ],
    ids=["the user's own PlatformIO", "settings of the user's shell"],
)
def test_the_users_surroundings_do_not_change_the_binary(
    settings: dict[str, str], project: Project, fresh_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        for name, value in settings.items():
            patch.setenv(name, value)
        built = build(project())
    monkeypatch.setenv("XDG_CACHE_HOME", str(fresh_cache / "another"))
    assert built.flash_bytes == build(project()).flash_bytes


def test_two_at_once_share_one_build(project: Project, fresh_cache: Path) -> None:
    folder = project()
    both = [
        subprocess.Popen([sys.executable, "-c", BUILD, folder], stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    printed = [process.communicate()[0].splitlines() for process in both]
    assert [process.returncode for process in both] == [0, 0]
    assert printed[0][-1] == printed[1][-1]
    assert sorted(len(lines) > 1 for lines in printed) == [False, True]


def test_an_interrupted_build_leaves_nothing_behind(project: Project, fresh_cache: Path) -> None:
    folder = project()
    words = [sys.executable, "-c", BUILD, folder]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert process.stdout is not None
    assert process.stdout.readline().startswith("Compiling")
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=20)
    assert process.returncode != 0
    assert still_running(str(fresh_cache)) == []
    assert not build(folder).cached


def still_running(word: str) -> list[str]:
    """Commands on this machine that name `word` (Linux: from /proc)."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            command = entry.read_bytes().replace(b"\0", b" ").decode(errors="replace")
        except OSError:
            continue
        if word in command and int(entry.parent.name) != os.getpid():
            found.append(command)
    return found


def test_only_builds_long_unused_are_removed(project: Project, fresh_cache: Path) -> None:
    elf = build(project()).elf
    builds = fresh_cache / "builds"
    forget_old(builds, time.time() + KEPT_S - 60)
    assert elf.is_file()
    forget_old(builds, time.time() + KEPT_S + 60)
    assert list(builds.iterdir()) == []
