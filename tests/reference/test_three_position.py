"""Heater, cooler, or neither: by hand, with numbers that single precision holds exactly."""

import pytest
from player import Player

from heatwright.spec import ThreePosition

FREE = {"heating": None, "runaway": None, "frozen": None, "rising_while_off": None}
HEATS, RESTS, COOLS = (100.0, 0), (0.0, 0), (0.0, 1)
BELOW_TO_ABOVE_C = [47.9375, 48.0, 50.0, 52.0, 52.0625]


def three_position(vary, **limits):
    algorithm = ThreePosition.model_validate({"kind": "three_position", **limits})
    return Player(vary(**FREE, algorithm=algorithm))


def switched(records):
    return [(float(each["duty_percent"]), each["algorithm.cooling"]) for each in records]


def test_the_ends_of_the_band_belong_to_it(vary):
    player = three_position(vary, dead_band="2 K")
    assert switched(player.feed_all(BELOW_TO_ABOVE_C)) == [HEATS, RESTS, RESTS, RESTS, COOLS]
    assert switched(player.feed_all(BELOW_TO_ABOVE_C[::-1])) == [COOLS, RESTS, RESTS, RESTS, HEATS]


def test_with_hysteresis_it_goes_on_into_the_band(vary):
    player = three_position(vary, dead_band="2 K", hysteresis="1.5 K")
    upwards = [48.0, 47.9375, 49.4375, 49.5, 48.0, 52.0, 52.0625, 50.5625, 50.5, 52.0]
    expected = [RESTS, HEATS, HEATS, RESTS, RESTS, RESTS, COOLS, COOLS, RESTS, RESTS]
    assert switched(player.feed_all(upwards)) == expected


def test_a_hysteresis_as_wide_as_the_band_ends_at_the_setpoint(vary):
    player = three_position(vary, dead_band="2 K", hysteresis="2 K")
    assert switched(player.feed_all([47.0, 49.9375, 50.0])) == [HEATS, HEATS, RESTS]
    assert switched(player.feed_all([53.0, 50.0625, 50.0])) == [COOLS, COOLS, RESTS]


def test_a_setpoint_that_jumps_turns_one_into_the_other(vary):
    player = three_position(vary, dead_band="2 K", hysteresis="2 K")
    assert switched([player.feed(47.0)]) == [HEATS]
    player.setpoint_c = 40.0
    assert switched([player.feed(47.0)]) == [COOLS]
    player.setpoint_c = 60.0
    assert switched([player.feed(47.0)]) == [HEATS]


def test_lead_adds_the_filtered_slope(vary):
    player = three_position(vary, dead_band="2 K", lead="4 s", lead_filter="1 s")
    records = player.feed_all([46.0, 47.0, 47.0, 51.0])
    assert [float(each["algorithm.rate_k_per_s"]) for each in records] == [0, 0.5, 0.25, 2.125]
    # expected 46, 49, 48, 59.5 °C
    assert switched(records) == [HEATS, RESTS, RESTS, COOLS]


def test_the_slope_is_kept_over_missing_readings(vary):
    player = three_position(vary, dead_band="2 K", lead="4 s", lead_filter="1 s")
    player.feed_all([40.0, 41.0])
    assert player.miss()["algorithm.heating"] == 1
    assert player.feed(43.0)["algorithm.rate_k_per_s"] == 0.5


def test_a_fault_resets_it(vary):
    player = three_position(vary, dead_band="2 K", lead="4 s", lead_filter="1 s")
    player.feed_all([40.0, 41.0])
    record = player.feed(51.0)
    members = ("rate_k_per_s", "heating", "cooling")
    assert record["fault.code"] == 8
    assert [record[f"algorithm.{member}"] for member in members] == [0, 0, 0]


@pytest.mark.parametrize("temperature_c", [0.0, 47.5, 48.0, 50.0, 52.0, 52.5, 69.0])
def test_never_both(vary, temperature_c):
    player = three_position(vary, dead_band="2 K", hysteresis="2 K", lead="5 s")
    for reading_c in (40.0, temperature_c, temperature_c, 60.0, temperature_c):
        record = player.feed(reading_c)
        assert not (record["algorithm.heating"] and record["algorithm.cooling"])
