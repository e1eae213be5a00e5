from collections.abc import Callable
from functools import cache

import host_specs
import pytest
from host_specs import build_of_spec
from rig.firmware import spec_of
from storage_specs import NAMES, text_of

from heatwright.sim.host import Host

Hosts = Callable[[str], Host]


@pytest.fixture(scope="session")
def hosts() -> Hosts:
    """The host build of each specification, or of a machine with programs, by its name."""

    @cache
    def host(name: str) -> Host:
        spec = spec_of(text_of(name)) if name in NAMES else host_specs.spec_of(name)
        return Host(build_of_spec(spec))

    return host
