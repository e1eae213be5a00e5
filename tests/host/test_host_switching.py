"""Switched and cooled loops, tick by tick."""

import host_switched
import pytest
from host_switching import switching_problem


@pytest.mark.parametrize("name", list(host_switched.texts()))
def test_switches_at_once_and_refuses_what_it_says(hosts, name):
    assert switching_problem(hosts(name)) == ""
