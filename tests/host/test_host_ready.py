"""A commanded loop is ready only for what was asked of it last."""

import host_specs
import pytest
from host_ready import ready_problem

WITH_AIR = [name for name in host_specs.HOSTED if "loops:\n  air:" in host_specs.TEXTS[name]]


@pytest.mark.parametrize("name", WITH_AIR)
def test_is_ready_only_for_the_newest_command(hosts, name):
    assert ready_problem(hosts(name)) == ""
