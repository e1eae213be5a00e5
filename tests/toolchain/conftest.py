import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

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


def smallest(folder: Path) -> Path:
    """Write the small project."""
    for name, text in SMALLEST.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(textwrap.dedent(text).strip() + "\n")
    return folder


@pytest.fixture
def blink(tmp_path: Path) -> Path:
    """The small project as it is."""
    return smallest(tmp_path / "blink")


@pytest.fixture
def project(tmp_path: Path) -> Callable[..., Path]:
    """The small project, with other lines in its files."""

    def changed(board: str = "uno", ini: str = "", main: str | None = None) -> Path:
        folder = smallest(tmp_path / "project")
        text = (folder / "platformio.ini").read_text().replace("uno", board)
        (folder / "platformio.ini").write_text(text + ini)
        if main is not None:
            (folder / "src" / "main.c").write_text(main)
        return folder

    return changed


@pytest.fixture
def fresh_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache of the user's."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "heatwright"
