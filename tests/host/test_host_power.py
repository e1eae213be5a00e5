"""A program's way through losses of power: what is noted, when, and what comes of it."""

import host_specs
import pytest
from host_power import power_problem


@pytest.mark.parametrize("name", host_specs.PROGRAMMED)
def test_goes_on_or_ends_as_the_page_says(hosts, name):
    assert power_problem(hosts(name), name) == ""
