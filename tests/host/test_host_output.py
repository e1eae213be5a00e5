"""Outputs by themselves: every duty, with an open and a closed gate.

Those with minimum times answer to more than a duty: `tests/outputs` has them, tick by tick.
"""

import host_specs
import pytest
from host_output import output_problem

AT_ONCE = [
    name
    for name in host_specs.NAMES
    if "kind: digital, pin: D3, minimum_" not in host_specs.TEXTS[name]
]


@pytest.mark.parametrize("name", AT_ONCE)
def test_every_duty_drives_the_heater_as_long_as_it_should(hosts, name):
    assert output_problem(hosts(name)) == ""
