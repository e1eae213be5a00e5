"""Outputs by themselves: every duty, with an open and a closed gate."""

import host_specs
import pytest
from host_output import output_problem


@pytest.mark.parametrize("name", host_specs.NAMES)
def test_every_duty_drives_the_heater_as_long_as_it_should(hosts, name):
    assert output_problem(hosts(name)) == ""
