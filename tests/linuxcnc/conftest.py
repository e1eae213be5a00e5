import shutil
from collections.abc import Iterator
from pathlib import Path

import hal_session
import pytest
from hal_session import FABRICATOR, Hal, MadeUpBoard, linuxcnc_files
from rig.specs import files_of

ALONE = """
loadrt threads name1=servo-thread period1=1000000
source fabricator.hal
start
"""


@pytest.fixture
def linuxcnc() -> None:
    """LinuxCNC's HAL; in CI a test that is skipped for the want of it fails."""
    absent = [tool for tool in hal_session.TOOLS if shutil.which(tool) is None]
    if absent:
        pytest.skip(f"LinuxCNC is not installed ({', '.join(absent)}): make setup LINUXCNC=1")


@pytest.fixture(scope="session")
def generated() -> dict[str, str]:
    """The LinuxCNC files of the fabricator by their names."""
    return linuxcnc_files(files_of(FABRICATOR))


@pytest.fixture
def place(generated: dict[str, str]) -> Iterator[Path]:
    """A folder with the generated files, but no parity: the kernel's pseudo-terminals have none."""
    with hal_session.folder() as folder:
        for name, text in generated.items():
            (folder / name).write_text(text.replace("SERIAL_PARITY = even", "SERIAL_PARITY = none"))
        (folder / "test.hal").write_text(ALONE)
        yield folder


@pytest.fixture
def board(place: Path) -> Iterator[MadeUpBoard]:
    with MadeUpBoard() as board:
        (place / "fabricator_port").symlink_to(board.port)
        yield board


@pytest.fixture
def hal(linuxcnc: None, board: MadeUpBoard, place: Path) -> Iterator[Hal]:
    """The generated HAL with the made-up board, no panel."""
    with Hal(place, "test.hal") as session:
        session.wait("fabricator-exchange", 1)
        yield session
