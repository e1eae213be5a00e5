import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from host_builds import build_of

from heatwright.sim.host import Host

sys.path.append(str(Path(__file__).parents[1] / "storage"))  # what settings must stand

Hosts = Callable[[str], Host]


@pytest.fixture(scope="session")
def hosts() -> Hosts:
    """The host build of each specification, by its name."""

    @cache
    def host(name: str) -> Host:
        return Host(build_of(name))

    return host
