"""Progress in EEPROM: the ring of records under power cuts, damage and wrap."""

import pytest
from storage_progress import Progresses

NAMES = ("few", "usual", "pausing")


@pytest.fixture(scope="module", params=NAMES)
def progress(request, builds):
    found = Progresses(builds(request.param))
    yield found
    assert list(found.beyond()) == []


@pytest.mark.parametrize("check", ["blank", "first_cuts", "wishes", "wear", "half", "foreign"])
def test_holds(progress, check):
    assert list(getattr(progress, check)()) == []


def test_the_newest_counts_wherever_it_is(progress):
    assert list(progress.newest(range(progress.memory.progress_slots))) == []


def test_a_cut_at_every_byte_of_every_slot_leaves_old_or_new(progress):
    assert list(progress.cuts(range(progress.memory.progress_slots))) == []


def test_whatever_a_torn_write_leaves(progress):
    every = 1 if progress.memory.progress_slots < 50 else 17
    assert list(progress.cuts((3,), range(0, 256, every))) == []


def test_damaged_records_are_passed_over(progress):
    assert [problem for seed in range(300) for problem in progress.damaged(seed)] == []


def test_any_bytes(progress):
    assert [problem for seed in range(150) for problem in progress.noise(seed)] == []
