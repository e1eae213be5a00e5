"""From columns and units to a record, or to what is missing."""

import re

import numpy as np
import pytest

from heatwright.sim.identify import (
    Record,
    Scales,
    Unusable,
    chosen_roles,
    named_roles,
    read_log,
    record_of,
)

SCALES = Scales(power_w=40.0)


def rows(header: str = "", count: int = 20, line: str = "{0},{1},{2}") -> str:
    body = "".join(
        line.format(k, 20 + max(0, k - 5), 100 if k >= 5 else 0) + "\n" for k in range(count)
    )
    return f"{header}\n{body}" if header else body


def record(text: str, columns: str | None = None, scales: Scales = SCALES) -> Record:
    log = read_log(text.encode())
    if columns is None:
        return record_of(log, named_roles(log.names), scales)
    width = log.values.shape[1]
    return record_of(log, chosen_roles(columns, log.names, width, stamped=log.stamped), scales)


@pytest.mark.parametrize(
    "header",
    [
        "time,temperature,duty",
        "t,temp,pwm",
        "time [s],air.temperature_c [°C],air.duty_percent [%]",
        "elapsed,T,heater",
        "Timestamp (s),T0,Output (%)",
    ],
)
def test_columns_are_known_by_their_names(header: str) -> None:
    found = record(rows(header))
    assert found.times_s.tolist() == list(range(20))
    assert (found.readings_c[0], found.readings_c[-1]) == (20, 34)
    assert found.steps == ((5.0, 0.0, 40.0),)


def test_the_simulations_own_csv_is_known() -> None:
    header = (
        "time [s],element [°C],air [°C],air sensed [°C],heater on [1],air.setpoint_c [°C],"
        "air.temperature_c [°C],air.duty_percent [%],air.asked_percent [%],"
        "air.fault.temperature_c [°C]"
    )
    line = "{0},1,2,3,0.5,50,{1},{2},9,9"
    found = record(rows(header, line=line))
    assert (found.readings_c[-1], found.powers_w[-1]) == (34, 40)


@pytest.mark.parametrize(
    ("columns", "line"),
    [
        ("time,temperature,duty", "{0},{1},{2}"),
        ("duty,-,temperature,time", "{2},7,{1},{0}"),
        ("temperature=2,time=1,duty=3", "{0},{1},{2}"),
    ],
)
def test_columns_as_the_user_says(columns: str, line: str) -> None:
    found = record(rows(line=line), columns)
    assert (found.times_s[-1], found.readings_c[-1], found.powers_w[-1]) == (19, 34, 40)


def test_a_name_chooses_among_several() -> None:
    text = rows("time,temp_in,temp_out,duty", line="{0},{1},99,{2}")
    with pytest.raises(Unusable, match="several columns that could be the temperature"):
        record(text)
    assert record(text, "temperature=temp_in").readings_c[-1] == 34


def test_units_of_the_header_and_of_the_user() -> None:
    found = record(
        rows("time [min],temperature [°F],power [kW]", line="{0},68,{2}").replace("68", "77", 1)
    )
    assert found.times_s[-1] == 19 * 60
    assert found.readings_c[-1] == pytest.approx(20)
    assert found.powers_w[-1] == 100_000
    assert record(rows(), "time[ms],temperature[K],duty").times_s[-1] == pytest.approx(0.019)
    assert record(rows("ms,temp,duty")).times_s[-1] == pytest.approx(0.019)


@pytest.mark.parametrize(
    ("line", "scales", "full_w"),
    [
        ("{0},{1},{2}", Scales(40.0), 40.0),
        ("{0},{1},{2}", Scales(40.0, full=255.0), 40.0 * 100 / 255),
        ("{0},{1},{2}", Scales(40.0, full=200.0), 20.0),
    ],
)
def test_what_full_duty_is(line: str, scales: Scales, full_w: float) -> None:
    found = record(rows(line=line), "time,temperature,duty", scales)
    assert found.powers_w[-1] == pytest.approx(full_w)


def test_a_switch_of_zero_and_one_is_a_share() -> None:
    found = record(rows().replace(",100", ",1"), "time,temperature,duty")
    assert found.powers_w[-1] == 40
    assert any("duty of 1 " in note for note in found.notes)


def test_lines_without_times_take_a_period() -> None:
    text = rows(line="{1} {2}")
    with pytest.raises(Unusable, match="--period 1s"):
        record(text, "temperature,duty")
    found = record(text, "temperature,duty", Scales(40.0, period_s=0.5))
    assert found.duration_s == 9.5


def test_a_reset_in_between_leaves_the_longest_part() -> None:
    text = rows("time,temp,duty", 12) + rows(count=30)
    found = record(text)
    assert (found.rows, found.duration_s) == (30, 29)
    assert "time goes back 1 times" in found.notes[-1]


def test_rows_of_one_time_count_once() -> None:
    text = rows("time,temp,duty") + "19,35,100\n19,36,100\n"
    found = record(text)
    assert found.rows == 20
    assert found.readings_c[-1] == 36


def test_midnight() -> None:
    lines = [f"{(86390 + k) % 86400},{20 + k},{100 * (k > 3)}" for k in range(20)]
    found = record("time,temp,duty\n" + "\n".join(lines))
    assert np.diff(found.times_s).tolist() == [1.0] * 19


def test_impossible_readings_are_left_out() -> None:
    text = rows("time,temp,duty") + "20,-300,100\n21,99999,100\n22,inf,100\n23,,100\n"
    found = record(text)
    assert found.rows == 20
    assert (
        found.notes
        == (
            "lines of the log that were no readings: 4",
            "full power is taken to be a duty of 100 (--full says otherwise)",
        )[::-1]
    )


def test_the_resolution_is_the_least_difference() -> None:
    assert record(rows("time,temp,duty")).resolution_k == 1.0
    fine = Record(np.arange(4.0), np.array([20.1, 20.1625, 20.1, 20.4]), np.ones(4))
    assert fine.resolution_k == pytest.approx(0.0625)


@pytest.mark.parametrize(
    ("text", "columns", "scales", "reason"),
    [
        (rows(), None, SCALES, "does not name its columns"),
        (rows("a,b,c"), None, SCALES, "no column of temperature among a, b, c"),
        (rows("time,temp,x"), None, SCALES, "no column of duty or power"),
        (rows("time,temp,duty"), None, Scales(), "--power 40W"),
        (rows("time,temp,duty"), None, Scales(40.0, full=50.0), "duty of 100 where 50 is full"),
        (rows().replace(",100", ",255"), "time,temperature,duty", SCALES, "--full 255"),
        (rows(), "time,temperature,heat", SCALES, "column heat"),
        (rows(), "time,temperature,-,-,duty", SCALES, "has 3 columns; --columns names 5"),
        (rows(), "temperature=9,duty=3", SCALES, "no column 9; number them from 1 to 3"),
        (rows("time,temp,duty"), "temperature=hot", SCALES, "no column hot; it has time"),
        (rows("time,temp,duty", 4), None, SCALES, "has 4 readings in a row"),
        (rows("time,temp,duty").replace(",100", ",0"), None, SCALES, "never has the heater on"),
        (rows("time,temp,duty").replace(",100", ",-100"), None, SCALES, "below 0"),
        (rows("time,x,temp", line="{0},{1},7") + "", "time,-,temperature", SCALES, "duty or power"),
        (rows("time,duty,temp", line="{0},{2},7"), None, SCALES, "same temperature in every line"),
        (rows("time [fortnight],temp,duty"), None, SCALES, "times in fortnight"),
        (rows("time,temp,power [hp]"), None, Scales(), "power in hp"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_refused(
    text: str, columns: str | None, scales: Scales, reason: str
) -> None:
    with pytest.raises(Unusable, match=re.escape(reason)):
        record(text, columns, scales)
