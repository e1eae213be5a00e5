"""Where everything stands in the EEPROM, and how long it lasts."""

import re
from itertools import pairwise, product

import pytest
from rig.firmware import ROOT, files_of, spec_of
from storage_format import PROGRESS_BYTES, Memory
from storage_specs import NAMES, board_text, text_of

from heatwright.spec import Controller, SpecError, load_text
from heatwright.spec.board.eeprom import CELL_WRITES, YEAR_S, layout, settings_bytes

BOARDS = ("uno", "leonardo", "mega2560")
FEWEST_SETTINGS, MOST_SETTINGS = 4, 16


@pytest.mark.parametrize("name", NAMES)
def test_the_firmware_has_the_same_layout(name):
    controller = spec_of(text_of(name)).controller
    areas, memory = layout(controller), Memory(controller)
    config = files_of(text_of(name))["src/config.h"]
    found = {key: int(n) for key, n in re.findall(r"#define (\w+_(?:EEPROM|SLOTS)) (\d+)u", config)}
    assert found == {
        "SETTINGS_SLOTS": areas.settings.slots,
        "PROGRAMS_EEPROM": areas.programs.start,
        "PROGRESS_EEPROM": areas.progress.start,
        "PROGRESS_SLOTS": areas.progress.slots,
    }
    assert areas.programs.slot_bytes == memory.program_bytes
    assert areas.progress.slot_bytes == PROGRESS_BYTES
    assert settings_bytes(controller) == memory.settings_bytes


def tried(board: str, programs: str) -> tuple[Controller | None, str]:
    """The controller, or why it is refused."""
    try:
        return load_text(board_text(board, programs), "tried.yaml").controller, ""
    except SpecError as error:
        return None, str(error)


SIZES = list(product(BOARDS, (3, 10, 20), (2, 3, 8), ("10 s", "1 min", "7 min", "1 h")))
PROGRAMS = "  points: {}\n  places: {}\n  save_every: {}"


def test_whatever_is_accepted_fits_and_lasts_ten_years():
    controllers = [tried(size[0], PROGRAMS.format(*size[1:]))[0] for size in SIZES]
    accepted = [each for each in controllers if each is not None]
    assert len(accepted) > len(SIZES) // 4
    for controller in accepted:
        areas, room = layout(controller), controller.board.eeprom_bytes
        assert areas.settings.start == 0
        assert all(one.end == other.start for one, other in pairwise(areas))
        assert areas.end <= room
        assert FEWEST_SETTINGS <= areas.settings.slots <= MOST_SETTINGS
        every_s = controller.programs.save_every_s
        assert areas.progress.slots * CELL_WRITES * every_s >= 10 * YEAR_S
        assert areas.progress.slots <= 255
        assert room - areas.end < PROGRESS_BYTES or areas.progress.slots == 255


def test_what_is_proposed_where_something_is_refused_is_accepted():
    proposals = 0
    for board, points, places, every in SIZES:
        controller, why = tried(board, PROGRAMS.format(points, places, every))
        proposed = re.search(r"Use save_every: ([^,.]+), or", why)
        if proposed:
            proposals += 1
            assert tried(board, PROGRAMS.format(points, places, proposed[1]))[1] == ""
        elif controller is None:
            assert "bytes, and the EEPROM of the" in why
    assert proposals > len(SIZES) // 4


@pytest.mark.parametrize(("board", "every"), [("mega2560", "1 min"), ("uno", "11 min")])
def test_the_page_says_how_long_it_lasts(board, every):
    page = (ROOT / "docs" / "storage.md").read_text(encoding="utf-8")
    programs = f"  save_every: {every}"
    controller = load_text(board_text(board, programs), "page.yaml").controller
    areas = layout(controller)
    years = areas.progress.years(controller.programs.save_every_s)
    words = f"{areas.settings.slots} slots of settings, {areas.progress.slots} of progress: "
    assert f"{words}{int(years * 10) / 10:.1f} years" in page
    assert f"`save_every: {every}`" in page
    assert f"{areas.programs.slot_bytes - 70} bytes, and 7 for each of `points`" in page
    assert f"| {areas.progress.slot_bytes} bytes |" in page
