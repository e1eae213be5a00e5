"""A bare chip's README tells which fuses to set; a board's does not."""

import pytest
from moved import EXAMPLES, moved

from heatwright.generator import plan_firmware, render
from heatwright.spec import load, load_text

OLD = ("CKSEL, SUT and CKOPT", "BODEN and BODLEVEL", "4.0 V")
NEW = ("CKSEL, SUT and CKDIV8", "BODLEVEL", "4.3 V")


@pytest.mark.parametrize(
    ("board", "words"), [("atmega32", OLD), ("atmega16", OLD), ("atmega1284p", NEW)]
)
def test_fuses(board: str, words: tuple[str, ...]) -> None:
    spec = load_text(moved("hotplate", board), "hotplate.yaml")
    section = render(plan_firmware(spec))["README.md"].split("## Fuses")[1].split("##")[0]
    assert all(word in section for word in (*words, "16 MHz"))


def test_boards_have_theirs_set() -> None:
    spec = load(EXAMPLES / "hotplate.yaml")
    assert "Fuses" not in render(plan_firmware(spec))["README.md"]
