"""Writing a project where something is in the way, or fails half-way."""

import errno
import os
from pathlib import Path

import pytest
from project import FILES, OURS, encoded, everything

from heatwright.cli.ends import ended
from heatwright.cli.main import cli
from heatwright.generator import OutputRefused, write

EXAMPLE = Path(__file__).parents[2] / "spec" / "examples" / "chamber.yaml"


@pytest.mark.parametrize("target", ["elsewhere", "elsewhere/file", "missing", "README.md"])
@pytest.mark.parametrize("place", ["src", "README.md", "src/main.c"])
def test_a_link_in_the_way_is_not_followed(place: str, target: str, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    (folder / "src").mkdir(parents=True)
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "file").write_text(OURS)
    if place == "src":
        (folder / "src").rmdir()
    (folder / place).symlink_to(tmp_path / target)
    before = everything(tmp_path)
    with pytest.raises(OutputRefused, match="is a link and might lead elsewhere"):
        write(FILES, folder)
    assert everything(tmp_path) == before


def test_the_folder_itself_may_be_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "out").symlink_to("real")
    write(FILES, tmp_path / "out")
    assert everything(tmp_path / "real") == encoded(FILES)


@pytest.mark.parametrize(
    ("there", "reason"),
    [
        ("out", "is a file where a folder is needed"),
        ("out/src", "is a file where a folder is needed"),
        ("out/src/main.c/x", "is a folder where a file is needed"),
        ("out/README.md/x", "is a folder where a file is needed"),
    ],
)
def test_files_and_folders_that_are_not_what_is_needed(
    there: str, reason: str, tmp_path: Path
) -> None:
    (tmp_path / there).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / there).write_text(OURS)
    before = everything(tmp_path)
    with pytest.raises(OutputRefused, match=reason):
        write(FILES, tmp_path / "out")
    assert everything(tmp_path) == before


def test_a_pipe_in_the_way_is_not_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "README.md")
    with pytest.raises(OutputRefused, match="was not written by heatwright"):
        write(FILES, tmp_path)
    assert not (tmp_path / "src").exists()


@pytest.mark.parametrize("moment", ["write", "replace"])
def test_a_failure_leaves_the_old_file_whole(
    moment: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(FILES, tmp_path)
    before = everything(tmp_path)

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    if moment == "write":
        monkeypatch.setattr("heatwright.generator.output.os.fdopen", full)
    else:
        monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(OSError, match="No space left"):
        write({path: f"{text}// more\n" for path, text in FILES.items()}, tmp_path)
    assert everything(tmp_path) == before


def test_ctrl_c_leaves_the_old_file_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(FILES, tmp_path)
    before = everything(tmp_path)

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "chmod", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write({path: f"{text}// more\n" for path, text in FILES.items()}, tmp_path)
    assert everything(tmp_path) == before


def test_a_folder_that_cannot_be_written_to_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """The permission bits do not bind root, who runs the tests in many a container."""

    def denied(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(tmp_path / "src"))

    monkeypatch.setattr("heatwright.generator.output.tempfile.mkstemp", denied)
    with pytest.raises(PermissionError):
        write(FILES, tmp_path)
    assert everything(tmp_path) == {}
    assert ended(cli, ["generate", str(EXAMPLE), "-o", str(tmp_path)]) == 2
    assert "src: permission denied." in capfd.readouterr().err
    # Here nobody may make a folder.
    assert ended(cli, ["generate", str(EXAMPLE), "-o", "/proc/heatwright"]) == 2
    said = capfd.readouterr()
    assert "/proc/heatwright" in said.err
    assert "Traceback" not in said.out + said.err
