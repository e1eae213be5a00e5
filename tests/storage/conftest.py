from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from storage_specs import build_of

from heatwright.sim.host import HostBuild

Builds = Callable[[str], HostBuild]


@pytest.fixture(scope="session")
def builds(tmp_path_factory: pytest.TempPathFactory) -> Builds:
    """The host build of each machine, by its name."""
    folder: Path = tmp_path_factory.mktemp("storage")
    return cache(lambda name: build_of(name, folder))
