"""All of the kind is there: heatwright says what is missing, and in which file."""

from heatwright.cli.contract import lacking


def test_nothing_is_missing() -> None:
    assert list(lacking("sensor", "newsensor")) == []
