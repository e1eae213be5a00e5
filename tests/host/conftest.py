from collections.abc import Callable
from functools import cache

import pytest
from host_builds import build_of

from heatwright.sim.host import Host

Hosts = Callable[[str], Host]


@pytest.fixture(scope="session")
def hosts() -> Hosts:
    """The host build of each specification, by its name."""

    @cache
    def host(name: str) -> Host:
        return Host(build_of(name))

    return host
