import pytest
from fault_machines import site_of

from heatwright.sim.faults.world import Site


@pytest.fixture(scope="session")
def site() -> Site:
    """The chamber."""
    return site_of("chamber")
