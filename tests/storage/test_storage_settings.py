"""The maximum that an operator has lowered, and the type of thermocouple that he has chosen."""

import pytest
from storage_settings import CHECKS, Settings


@pytest.fixture(scope="module", params=["few", "typed"])
def settings(request, builds):
    return Settings(builds(request.param))


@pytest.mark.parametrize("check", CHECKS)
def test_holds(settings, check):
    assert list(getattr(settings, check)()) == []
