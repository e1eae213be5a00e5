from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from host_builds import build_of

from heatwright.sim.host import Host

Hosts = Callable[[str], Host]


@pytest.fixture(scope="session")
def hosts(tmp_path_factory: pytest.TempPathFactory) -> Hosts:
    """The host build of each specification, by its name."""
    folder: Path = tmp_path_factory.mktemp("hosts")

    @cache
    def host(name: str) -> Host:
        return Host(build_of(name, folder))

    return host
