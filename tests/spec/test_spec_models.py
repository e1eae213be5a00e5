"""Names, titles, the clock, and the rules of protection."""

import pytest
from rig.bad_specs import bases

from heatwright.spec import SpecError, load_text
from heatwright.spec.names import LONGEST_NAME
from heatwright.spec.rules import RULES

LEAST = bases()["oven"]
IDS = """
    sensor_no_answer sensor_short sensor_crc sensor_stale sensor_reset over_temperature
    under_temperature rise_rate sensor_frozen heating_failed runaway_above runaway_below
    rising_while_off watchdog_reset brown_out settings_corrupt sensor_open sensor_range
    emergency_stop over_current current_while_off no_current master_lost program_lags
    relay_welded relay_open
"""
"""Of the rules, from code 1 on."""


def test_the_default_maximum_follows_the_setpoint() -> None:
    text = LEAST.replace("maximum: 70 °C", "maximum: 60 °C")
    assert load_text(text).controller.loops["air"].protection.maximum_c == 75.0
    given = text + "    protection: {maximum: 66 °C}\n"
    assert load_text(given).controller.loops["air"].protection.maximum_c == 66.0


def test_protections_switched_off() -> None:
    text = "    protection: {heating: off, runaway: off, frozen: off, rising_while_off: off}\n"
    protection = load_text(LEAST + text).controller.loops["air"].protection
    rules = (protection.heating, protection.runaway, protection.frozen, protection.rising_while_off)
    assert rules == (None, None, None, None)


def test_the_board_runs_at_its_clock() -> None:
    assert load_text(LEAST).controller.board.clock_hz == 16_000_000
    slow = LEAST.replace("board: uno", "board: uno, clock: 8 MHz")
    controller = load_text(slow).controller
    assert controller.identity.clock_hz == 8e6
    assert controller.board.clock_hz == 8_000_000
    assert isinstance(controller.board.clock_hz, int)


def test_rules_keep_their_codes() -> None:
    assert {code: rule.id for code, rule in RULES.items()} == dict(enumerate(IDS.split(), start=1))
    for code, rule in RULES.items():
        assert rule.code == code
        assert 1 <= len(rule.display) <= 12
        assert rule.display.isascii()
        assert rule.display == rule.display.upper()
        assert rule.meaning.endswith(".")
        assert rule.remedy.endswith(".")


def test_a_name_may_be_as_long_as_it_says() -> None:
    longest = "a" * LONGEST_NAME
    assert load_text(LEAST.replace("name: oven", f"name: {longest}"))
    with pytest.raises(SpecError, match=f"Use at most {LONGEST_NAME} characters"):
        load_text(LEAST.replace("name: oven", f"name: {longest}a"))
