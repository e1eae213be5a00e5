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


BY_NAME = "time,temperature,duty"
OWN_CSV = (
    "time [s],element [°C],air [°C],air sensed [°C],heater on [1],air.setpoint_c [°C],"
    "air.temperature_c [°C],air.duty_percent [%],air.asked_percent [%],air.fault.temperature_c [°C]"
)
"""What `simulate --csv` writes."""


@pytest.mark.parametrize(
    ("text", "columns", "scales", "ends"),
    [
        *((rows(header), None, SCALES, (19, 34, 40)) for header in (
            BY_NAME, "t,temp,pwm", "time [s],air.temperature_c [°C],air.duty_percent [%]",
            "elapsed,T,heater", "Timestamp (s),T0,Output (%)",
        )),
        (rows(OWN_CSV, line="{0},1,2,3,0.5,50,{1},{2},9,9"), None, SCALES, (19, 34, 40)),
        (rows(), BY_NAME, SCALES, (19, 34, 40)),
        (rows(line="{2},7,{1},{0}"), "duty,-,temperature,time", SCALES, (19, 34, 40)),
        (rows(), "temperature=2,time=1,duty=3", SCALES, (19, 34, 40)),
        (rows("time,temp_in,temp_out,duty", line="{0},{1},99,{2}"), "temperature=temp_in", SCALES,
         (19, 34, 40)),
        (rows("time [min],temperature [°F],power [kW]", line="{0},77,{2}").replace("77", "68", 1),
         None, SCALES, (19 * 60, 25, 100_000)),
        (rows(), "time[ms],temperature[K],duty", SCALES, (0.019, 34 - 273.15, 40)),
        (rows("ms,temp,duty"), None, SCALES, (0.019, 34, 40)),
        (rows(), BY_NAME, Scales(40.0, full=255.0), (19, 34, 40 * 100 / 255)),
        (rows(), BY_NAME, Scales(40.0, full=200.0), (19, 34, 20)),
        (rows().replace(",100", ",1"), BY_NAME, SCALES, (19, 34, 40)),  # a switch of 0 and 1
        (rows(line="{1} {2}"), "temperature,duty", Scales(40.0, period_s=0.5), (9.5, 34, 40)),
        (rows(BY_NAME) + "19,35,100\n19,36,100\n", None, SCALES, (19, 36, 40)),  # count once
    ],
)  # fmt: skip
def test_columns_and_units(
    text: str, columns: str | None, scales: Scales, ends: tuple[float, ...]
) -> None:
    found = record(text, columns, scales)
    assert found.rows == 20
    assert (found.times_s[-1], found.readings_c[-1], found.powers_w[-1]) == pytest.approx(ends)
    begins_s = 5 / 19 * found.times_s[-1]
    assert found.steps == ((pytest.approx(begins_s), 0.0, pytest.approx(ends[-1])),)


def test_a_duty_of_one_is_taken_to_be_full_and_said_so() -> None:
    found = record(rows().replace(",100", ",1"), BY_NAME)
    assert any("duty of 1 " in note for note in found.notes)


def test_a_reset_in_between_leaves_the_longest_part() -> None:
    text = rows("time,temp,duty", 12) + rows(count=30)
    found = record(text)
    assert (found.rows, found.duration_s) == (30, 29)
    assert "time goes back 1 times" in found.notes[-1]


def test_midnight() -> None:
    lines = [f"{(86390 + k) % 86400},{20 + k},{100 * (k > 3)}" for k in range(20)]
    found = record("time,temp,duty\n" + "\n".join(lines))
    assert np.diff(found.times_s).tolist() == [1.0] * 19


def test_impossible_readings_are_left_out() -> None:
    text = rows("time,temp,duty") + "20,-300,100\n21,99999,100\n22,inf,100\n23,,100\n"
    found = record(text)
    assert found.rows == 20
    assert found.notes == (
        "full power is taken to be a duty of 100 (--full says otherwise)",
        "lines of the log that were no readings: 4",
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
        (rows("time,x,temp", line="{0},{1},7"), "time,-,temperature", SCALES, "duty or power"),
        (rows("time,duty,temp", line="{0},{2},7"), None, SCALES, "same temperature in every line"),
        (rows("time,temp_in,temp_out,duty", line="{0},{1},99,{2}"), None, SCALES,
         "several columns that could be the temperature"),
        (rows(line="{1} {2}"), "temperature,duty", SCALES, "--period 1s"),
        (rows("time [fortnight],temp,duty"), None, SCALES, "times in fortnight"),
        (rows("time,temp,power [hp]"), None, Scales(), "power in hp"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_refused(
    text: str, columns: str | None, scales: Scales, reason: str
) -> None:
    with pytest.raises(Unusable, match=re.escape(reason)):
        record(text, columns, scales)
