"""The mean that control goes by, and the readings that the protections judge."""

import numpy as np
import pytest
from programmed_kiln import Kiln, controller_of

OVER_TEMPERATURE, RISE_RATE, OPEN = 6, 8, 17


def averaged(number=3, **parts):
    return Kiln(controller_of(average=f"moving_average: {number}", **parts))


def means(kiln, temperatures_c):
    return [float(record["temperature_c"]) for record in kiln.feed_all(temperatures_c)]


def test_the_first_reading_fills_the_window():
    assert means(averaged(), [30.0, 60.0, 90.0, 90.0]) == pytest.approx([30.0, 40.0, 60.0, 80.0])


def test_the_sum_is_in_the_order_of_the_slots_and_single():
    """The fourth reading takes the place of the first: (4th + 2nd) + 3rd, times a single 1/3."""
    readings = [np.float32(x) for x in (1000.5078125, 0.0234375, 777.125, 33.3359375)]
    kiln = averaged()
    record = kiln.feed_all([float(x) for x in readings])[-1]
    expected = (readings[3] + readings[1] + readings[2]) * np.float32(1 / 3)
    assert record["temperature_c"] == expected


def test_a_missing_reading_leaves_the_window_as_it_is():
    kiln = averaged()
    kiln.feed_all([30.0, 60.0])
    assert float(kiln.miss()["temperature_c"]) == pytest.approx(40.0)
    assert float(kiln.feed(90.0)["temperature_c"]) == pytest.approx(60.0)


def test_without_one_there_is_no_second_temperature():
    assert "reading_c" not in Kiln().feed(20.0)


def test_the_protections_judge_the_single_reading():
    kiln = averaged(16)
    kiln.feed_all([20.0] * 20)
    record = kiln.feed(1100.0)
    assert (record["fault.code"], record["fault.temperature_c"]) == (OVER_TEMPERATURE, 1100.0)
    assert record["temperature_c"] < 100


def test_a_jump_is_one_of_the_readings():
    kiln = averaged(rise="5 K/s")
    kiln.feed_all([20.0, 25.0, 30.0])
    assert kiln.record["fault.code"] == 0
    assert kiln.feed(35.0078125)["fault.code"] == RISE_RATE


def test_a_broken_sensor_tells_of_the_last_reading():
    kiln = averaged()
    kiln.feed_all([20.0, 50.0])
    for _ in range(5):
        kiln.miss(OPEN)
    assert (kiln.record["fault.code"], kiln.record["fault.temperature_c"]) == (OPEN, 50.0)


def test_the_band_is_that_of_the_readings():
    kiln = averaged(16)
    kiln.start(2)
    kiln.feed(20.0)
    kiln.feed_all([50.0] * 3)
    assert kiln.record["fault.code"] == 11
    assert kiln.record["temperature_c"] < 30


def test_a_reading_of_19_bits_has_room():
    record = Kiln(controller_of(frozen="{for: 10 s}", algorithm="ki: 1")).feed(1000.0)
    assert (record["reading_raw"], record["guard.frozen_raw"]) == (128_000, 128_000)
