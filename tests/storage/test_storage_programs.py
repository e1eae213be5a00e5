"""Programs in EEPROM: two slots under power cuts, damage and wrap."""

import pytest
from storage_programs import EMPTY, Programs

NAMES = ("few", "many", "usual")


@pytest.fixture(scope="module", params=NAMES)
def programs(request, builds):
    found = Programs(builds(request.param))
    yield found
    assert list(found.beyond()) == []


@pytest.mark.parametrize(
    "check",
    [
        "blank", "newest", "one_slot", "first_cuts", "emptied", "unchanged", "one_at_a_time",
        "half", "foreign", "unsound_in_eeprom", "sound", "crc",
    ],
)  # fmt: skip
def test_holds(programs, check):
    assert list(getattr(programs, check)()) == []


def test_a_cut_at_every_byte_of_every_slot_leaves_old_or_new(programs):
    places = programs.memory.places
    assert list(programs.cuts(range(1, places + 1, 1 if places < 8 else 7))) == []


def test_whatever_a_torn_write_leaves(programs):
    every = 1 if programs.memory.points < 10 else 17
    assert list(programs.cuts((2,), range(0, 256, every))) == []


def test_a_cut_while_a_place_is_emptied(programs):
    assert list(programs.cuts((1, 2), new=EMPTY)) == []


def test_damaged_slots_are_passed_over(programs):
    assert [problem for seed in range(300) for problem in programs.damaged(seed)] == []


def test_any_bytes(programs):
    assert [problem for seed in range(150) for problem in programs.noise(seed)] == []
