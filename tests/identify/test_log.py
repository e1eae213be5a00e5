"""Logs of many programs, and hostile ones, become rows of numbers, and those a record."""

import contextlib
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatwright.sim import identify

ROWS = [[20.0, 50.0, 100.0], [20.5, 50.0, 100.0], [21.25, 50.0, 0.0]]


def log(text: str) -> identify.Log:
    return identify.read_log(text.encode())


@pytest.mark.parametrize(
    "text",
    [
        "20,50,100\n20.5,50,100\n21.25,50,0\n", "20;50;100\n20.5;50;100\n21.25;50;0\n",
        "20,0;50,0;100,0\n20,5;50,0;100,0\n21,25;50,0;0,0\n",
        "20\t50\t100\n20.5\t50\t100\n21.25\t50\t0\n", "20 50 100\n20.5  50 100\n 21.25 50 0",
        "$20.00 50.00 100.00;\n$20.50 50.00 100.00;\r\n$21.25 50.00 0.00;\n",
        '"20","50","100"\r\n"20.5","50","100"\r\n"21.25","50","0"\r\n',
        "2.0e1, 50, 1E2\n20.5, 50, 100\n21.25, 50, 0",
    ],
)  # fmt: skip
def test_rows_without_names(text: str) -> None:
    found = log(text)
    assert found.values.tolist() == ROWS
    assert (found.names, found.dropped, found.stamped) == ((), 0, False)


@pytest.mark.parametrize(
    ("text", "names", "values", "dropped"),
    [
        *((f"{header}\n20,50,100\n20.5,50,100\n", ("temperature", "setpoint", "duty"), ROWS[:2], 0)
          for header in ("temperature,setpoint,duty", "# temperature, setpoint, duty",
                         '"temperature","setpoint","duty"')),
        ("temperature:20,duty:100\ntemperature:20.5,duty:100\nboot\nduty:0,temperature:21\n",
         ("temperature", "duty"), [[20, 100], [20.5, 100], [21, 0]], 1),
        ("ok T:20.1 /200.0 @:127\nok T:20.9 /200.0 @:64\necho:busy\n",  # a printer's reports
         ("T", "@", "T target"), [[20.1, 127, 200], [20.9, 64, 200]], 1),
    ],
)  # fmt: skip
def test_a_header_or_labels_name_the_columns(
    text: str, names: tuple[str, ...], values: list[list[float]], dropped: int
) -> None:
    found = log(text)
    assert (found.names, found.values.tolist(), found.dropped) == (names, values, dropped)


def test_clock_times_before_the_lines() -> None:
    found = log("23:59:59.500 -> 20,100\n00:00:00.500 -> 21,100\n00:00:01.500 -> 22,100\n")
    assert found.stamped
    assert found.values[:, :2].tolist() == [[20, 100], [21, 100], [22, 100]]
    assert np.diff(found.values[:, 2]).tolist() == [1.0, 1.0]


@pytest.mark.parametrize("time", ["2026-11-21T04:00:0{}", "2026-11-21 04:00:0{}", "04:00:0{}"])
def test_clock_times_in_a_column(time: str) -> None:
    found = log("".join(f"{time.format(second)},20.{second}\n" for second in range(4)))
    assert np.diff(found.values[:, 0]).tolist() == [1.0, 1.0, 1.0]


def test_junk_is_dropped_and_counted() -> None:
    found = log(
        ".5,100\n\ufeff*** boot 1.2.3 ***\ntime,temp,duty\n0,20,100\n1,20.5,100\nBrown-out!\n"
        "2,21\n3,2�.5,100\n4,nan,100\n5,22,100\ntime,temp,duty\n6,23,100,9\n7,24,100\n\n\n"
    )
    assert found.names == ("time", "temp", "duty")
    assert found.values[:, 0].tolist() == [0, 1, 4, 5, 7]
    assert np.isnan(found.values[2, 1])
    assert found.dropped == 7


def test_other_encodings() -> None:
    for encoding in ("utf-16", "utf-8-sig"):
        assert identify.read_log("20,50,100\n20.5,50,100\n".encode(encoding)).values.shape == (2, 3)
    assert identify.read_log(b"20\x00,50\xff\n20,50\n21,50\n").values.shape == (2, 2)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        *((data, "no rows of numbers")
          for data in (b"", b"\n\n", b"hello\nworld\n", b"\xff\xfe", b"nan,nan\n,,\n")),
        (b"1" * ((64 << 20) + 1), "larger than 64 MB"),
    ],
    ids=range(6),
)  # fmt: skip
def test_no_numbers_and_a_huge_file_are_refused(data: bytes, reason: str) -> None:
    with pytest.raises(identify.Unusable, match=reason):
        identify.read_log(data)


LIKE_A_LOG = st.text(alphabet="0123456789.,;:$-e \t\n@T", max_size=300).map(str.encode)


@given(st.one_of(st.binary(max_size=400), LIKE_A_LOG))
@settings(max_examples=200)
def test_no_bytes_break_it(data: bytes) -> None:
    with contextlib.suppress(identify.Unusable):
        assert identify.read_log(data).values.size


SCALES = identify.Scales(power_w=40.0)


def rows(header: str = "", count: int = 20, line: str = "{0},{1},{2}") -> str:
    values = [(k, 20 + max(0, k - 5), 100 if k >= 5 else 0) for k in range(count)]
    body = "".join(f"{line.format(*each)}\n" for each in values)
    return f"{header}\n{body}" if header else body


def record(
    text: str, columns: str | None = None, scales: identify.Scales = SCALES
) -> identify.Record:
    log = identify.read_log(text.encode())
    if columns is None:
        return identify.record_of(log, identify.named_roles(log.names), scales)
    width = log.values.shape[1]
    chosen = identify.chosen_roles(columns, log.names, width, stamped=log.stamped)
    return identify.record_of(log, chosen, scales)


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
        (rows(), BY_NAME, identify.Scales(40.0, full=255.0), (19, 34, 40 * 100 / 255)),
        (rows(), BY_NAME, identify.Scales(40.0, full=200.0), (19, 34, 20)),
        (rows().replace(",100", ",1"), BY_NAME, SCALES, (19, 34, 40)),  # a switch of 0 and 1
        (rows(line="{1} {2}"), "temperature,duty", identify.Scales(40.0, every_s=0.5),
         (9.5, 34, 40)),
        (rows(BY_NAME) + "19,35,100\n19,36,100\n", None, SCALES, (19, 36, 40)),  # count once
    ],
)  # fmt: skip
def test_columns_and_units(
    text: str, columns: str | None, scales: identify.Scales, ends: tuple[float, ...]
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
    fine = identify.Record(np.arange(4.0), np.array([20.1, 20.1625, 20.1, 20.4]), np.ones(4))
    assert fine.resolution_k == pytest.approx(0.0625)


@pytest.mark.parametrize(
    ("text", "columns", "scales", "reason"),
    [
        (rows(), None, SCALES, "does not name its columns"),
        (rows("a,b,c"), None, SCALES, "no column of temperature among a, b, c"),
        (rows("time,temp,x"), None, SCALES, "no column of duty or power"),
        (rows("time,temp,duty"), None, identify.Scales(), "--power 40W"),
        (rows("time,temp,duty"), None, identify.Scales(40.0, full=50.0),
         "duty of 100 where 50 is full"),
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
        (rows("time,temp,power [hp]"), None, identify.Scales(), "power in hp"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_refused(
    text: str, columns: str | None, scales: identify.Scales, reason: str
) -> None:
    with pytest.raises(identify.Unusable, match=re.escape(reason)):
        record(text, columns, scales)
