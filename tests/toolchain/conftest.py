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


@pytest.fixture
def project(tmp_path: Path) -> Callable[..., Path]:
    """Write the small project, with other lines in its files."""

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
    """An empty cache of the user's."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "heatwright"
