import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

BLINK = Path(__file__).parent / "blink"


@pytest.fixture
def project(tmp_path: Path) -> Callable[..., Path]:
    """A copy of the small project, with other lines in its files."""

    def changed(board: str = "uno", ini: str = "", main: str | None = None) -> Path:
        folder = tmp_path / "project"
        shutil.copytree(BLINK, folder)
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
