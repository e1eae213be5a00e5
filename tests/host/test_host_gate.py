"""The gate to the heater, tick by tick."""

import pytest
from host_gate import gate_problem


@pytest.mark.parametrize("name", ["switch_lead", "switch", "switch_band"])
def test_the_heater_is_on_only_while_every_permit_is_fresh(hosts, name):
    assert gate_problem(hosts(name)) == ""
