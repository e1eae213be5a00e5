"""Logs of many programs, and hostile ones, become rows of numbers or one clear sentence."""

import contextlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatwright.sim.identify import Log, Unusable, read_log

ROWS = [[20.0, 50.0, 100.0], [20.5, 50.0, 100.0], [21.25, 50.0, 0.0]]


def log(text: str) -> Log:
    return read_log(text.encode())


@pytest.mark.parametrize(
    "text",
    [
        "20,50,100\n20.5,50,100\n21.25,50,0\n",
        "20;50;100\n20.5;50;100\n21.25;50;0\n",
        "20,0;50,0;100,0\n20,5;50,0;100,0\n21,25;50,0;0,0\n",
        "20\t50\t100\n20.5\t50\t100\n21.25\t50\t0\n",
        "20 50 100\n20.5  50 100\n 21.25 50 0",
        "$20.00 50.00 100.00;\n$20.50 50.00 100.00;\r\n$21.25 50.00 0.00;\n",
        '"20","50","100"\r\n"20.5","50","100"\r\n"21.25","50","0"\r\n',
        "2.0e1, 50, 1E2\n20.5, 50, 100\n21.25, 50, 0",
    ],
)
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
         ("T", "@"), [[20.1, 127], [20.9, 64]], 1),
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
        assert read_log("20,50,100\n20.5,50,100\n".encode(encoding)).values.shape == (2, 3)
    assert read_log(b"20\x00,50\xff\n20,50\n21,50\n").values.shape == (2, 2)


@pytest.mark.parametrize("data", [b"", b"\n\n", b"hello\nworld\n", b"\xff\xfe", b"nan,nan\n,,\n"])
def test_no_numbers_are_refused(data: bytes) -> None:
    with pytest.raises(Unusable, match="no rows of numbers"):
        read_log(data)


def test_a_huge_file_is_refused() -> None:
    with pytest.raises(Unusable, match="larger than 64 MB"):
        read_log(b"1" * ((64 << 20) + 1))


@given(st.binary(max_size=400))
def test_no_bytes_break_it(data: bytes) -> None:
    with contextlib.suppress(Unusable):
        assert read_log(data).values.size


@given(st.text(alphabet="0123456789.,;:$-e \t\n@T", max_size=300))
def test_nothing_like_a_log_breaks_it(text: str) -> None:
    with contextlib.suppress(Unusable):
        assert log(text).values.size
