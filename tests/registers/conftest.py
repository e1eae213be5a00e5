from collections.abc import Mapping
from pathlib import Path

import pytest
from slave_spec import SLAVE
from slave_world import SANITIZE, STRICT, WORLD, compiled, linked, write_sources

from heatwright.generator import plan_firmware, render
from heatwright.spec import load_text


@pytest.fixture(scope="session")
def slave_files() -> Mapping[str, str]:
    return render(plan_firmware(load_text(SLAVE)))


@pytest.fixture(scope="session")
def slave_program(slave_files: Mapping[str, str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The slave as a program of this computer: see slave_world."""
    folder = tmp_path_factory.mktemp("slave")
    sources = write_sources(slave_files, folder)
    objects = compiled([*sources, WORLD], folder, folder / "objects", *SANITIZE, *STRICT)
    return linked(objects, folder / "world", *SANITIZE)
