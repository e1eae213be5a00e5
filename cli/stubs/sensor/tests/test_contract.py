"""The kind is complete: heatwright lists missing pieces with their files."""

from heatwright.cli.contract import lacking


def test_nothing_is_missing() -> None:
    assert list(lacking("sensor", "newsensor")) == []
