"""The README says how slow the filter of a pulsed current may be, and `check` goes by the same."""

import re

import pytest
from rig.firmware import changed, files_of

from heatwright.spec import SpecError, load_text

KINDS = {"limited": "limit: 3 A", "only watched": "trip: 3.75 A"}
TENTH_MS = 1e-4


def with_lag(text: str, lag_s: float) -> str:
    return changed(text, ("current: {of: heater}", f"current: {{of: heater, lag: {lag_s:.4f} s}}"))


@pytest.mark.parametrize("kind", KINDS)
def test_the_slowest_filter_that_it_names_is_allowed_and_no_slower_one(kind: str) -> None:
    text = changed("fabricator", ("limit: 3 A", KINDS[kind]))
    (told,) = re.findall(r"through an RC of ([\d.]+) s to ([\d.]+) s", files_of(text)["README.md"])
    fastest_s, slowest_s = map(float, told)
    assert fastest_s == 5 / 1000
    load_text(with_lag(text, slowest_s), "spec.yaml")
    with pytest.raises(SpecError, match="does not follow the current"):
        load_text(with_lag(text, slowest_s + TENTH_MS), "spec.yaml")
