"""The sizes of the suite: `make evidence` holds every test, SIZE=full all cases of each."""

from itertools import pairwise

import pytest
from suite import SIZES, TABLE, TESTS, drawn, held, share_of, subject_of

CASES = [f"tests/bench/test_x.py::test_y[{number}]" for number in range(10)]


@pytest.mark.parametrize("entry", TABLE["shares"])
def test_a_share_is_of_a_test_that_is_there_and_grows_to_all(entry: str) -> None:
    path, *names = entry.split("::")
    file = TESTS.parent / path
    assert file.exists()
    text = file.read_text("utf-8") if names else ""
    assert all(f"def {name}" in text or f"class {name}" in text for name in names)
    test, evidence, full = TABLE["shares"][entry]
    assert 0 <= test <= evidence <= full == 1
    assert evidence > 0, "the test would be in neither of the two commands"


@pytest.mark.parametrize("name", TABLE["amounts"])
def test_an_amount_grows_with_the_size_and_is_asked_for(name: str) -> None:
    amounts = TABLE["amounts"][name]
    assert len(amounts) == len(SIZES)
    assert 0 <= amounts[0] <= amounts[1] <= amounts[2]
    assert any(f'amount("{name}")' in path.read_text("utf-8") for path in TESTS.rglob("*.py"))


def test_every_folder_with_tests_is_of_one_subject() -> None:
    folders = [folder for each in TABLE["subjects"].values() for folder in each]
    assert len(folders) == len(set(folders))
    for path in TESTS.rglob("test_*.py"):
        assert subject_of(path.relative_to(TESTS.parent).as_posix())


def test_a_larger_share_holds_all_that_a_smaller_one_does() -> None:
    shares = [drawn(CASES, tenths / 10) for tenths in range(11)]
    assert [len(share) for share in shares] == list(range(11))
    assert all(less < more for less, more in pairwise(shares))
    assert len(drawn(CASES, 0.001)) == 1


def test_the_longest_entry_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    shares = {"tests/bench": [0.5] * 3, "tests/bench/test_x.py::test_y": [0.1] * 3}
    monkeypatch.setitem(TABLE, "shares", shares)
    assert share_of("tests/bench/test_x.py::test_y") == 0.1
    assert share_of("tests/bench/test_x.py::test_z") == 0.5
    assert share_of("tests/cli/test_x.py::test_y") == 1
    others = [case.replace("test_y", "test_z") for case in CASES]
    assert len(held([*CASES, *others])) == 1 + 5
