"""Switched and cooled loops, tick by tick."""

import host_specs
import host_switched
import pytest
from host_orders import orders_problem
from host_switching import switching_problem


@pytest.mark.parametrize("name", list(host_switched.texts()))
def test_switches_at_once_and_refuses_what_it_says(hosts, name):
    assert switching_problem(hosts(name)) == ""


@pytest.mark.parametrize("name", [*host_specs.PROGRAMMED, "touched"])
def test_takes_and_refuses_orders_as_the_page_says(hosts, name):
    assert orders_problem(hosts(name)) == ""
