"""Settings in EEPROM: the ring of records under power cuts, damage and wrap."""

import pytest
from host_kept import kept_problem
from host_storage import Storage

NAMES = [
    "switch_lead", "pid_hold", "tuned_hot", "tuned_slow", "switched_by_host", "three_held",
    "tuned_by_master",
]  # fmt: skip
"""Without and with a stored setpoint, with gains and without; a host may switch some off by 0, a
master others by their switch."""


@pytest.fixture(scope="module", params=NAMES)
def storage(request, hosts):
    found = Storage(hosts(request.param))
    yield found
    assert list(found.outside()) == []
    found.boot(bytes([0xFF]) * found.ring.bytes)


@pytest.mark.parametrize(
    "check",
    [
        "blank", "newest", "first_cuts", "few_damaged", "codes", "setpoints", "foreign",
        "other_layout", "oversized", "later", "wear", "late_change", "latch",
    ],
)  # fmt: skip
def test_holds(storage, check):
    assert list(getattr(storage, check)()) == []


def test_a_cut_at_every_byte_of_every_slot_leaves_old_or_new(storage):
    assert list(storage.cuts(range(storage.ring.slots))) == []


def test_whatever_a_torn_write_leaves(storage):
    assert list(storage.cuts(range(3, 4), range(256))) == []


def test_damaged_records_are_passed_over(storage):
    assert [problem for seed in range(150) for problem in storage.damaged(seed)] == []


def test_any_bytes(storage):
    assert [problem for seed in range(150) for problem in storage.noise(seed)] == []


@pytest.mark.parametrize("name", [*NAMES, "by_hand", "feeder"])
def test_what_a_host_sets_outlives_a_loss_of_power_if_kept(hosts, name):
    assert kept_problem(hosts(name)) == ""


def test_a_large_eeprom(hosts):
    storage = Storage(hosts("pid_error_run"))
    problems = [*storage.newest(), *storage.cuts(range(0, 16, 5)), *storage.wear()]
    assert [*problems, *storage.outside()] == []
