"""Order 7: segments put in, changed, taken away; all that was sent, or nothing."""

from pathlib import Path

import pytest
from touch_kiln import order

GIVEN = "1/5400/3600,4/0/1800,2/8000/1500,5/0/0,3/5100/0,"
"""Kind, tenths of a degree, seconds or tenths of a kelvin per hour."""


def points(kiln: Path, *orders: str, place: int = 3) -> str:
    return order(kiln, f"13 {place}", *orders).state["points"]


def test_the_example_of_the_source(kiln: Path) -> None:
    assert (
        points(kiln, "7 1,20,600:2,40,300:3,60,300:4,0,0:") == "1/6000/1200,1/3000/2400,4/0/3600,"
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1,20,600,0:", "1/6000/1200,"),
        ("1,150,600,1:", "2/6000/1500,"),
        ("1,150.25,600,1:", "2/6000/1503,"),
        ("1,0,600,2:", "3/6000/0,"),
        ("1,0,0,2:", "3/0/0,"),
        ("1,0,0,3:", "5/0/0,"),
        ("1,5,600,3:", "5/0/0,"),
        ("1,5,600,4:", "4/0/300,"),
        ("1,0.02,600:", "1/6000/1,"),
        ("1,2.02,600.04:", "1/6000/121,"),
        ("1,2.016,600.05:", "1/6001/121,"),
        ("1,44640,600:", "1/6000/2678400,"),
        ("1,2.01,600.049:", "1/6000/121,"),
        ("1,.5,1100:", "1/11000/30,"),
        ("1,5,-0:", "1/0/300,"),
    ],
)  # fmt: skip
def test_each_kind(kiln: Path, text: str, expected: str) -> None:
    assert points(kiln, f"7 {text}") == expected


UNSOUND = [
    "1,20,600", "1,20:", "1:", ":", ",", "1,20,600,:", "1,20,600,5:", "1,20,600,0,0:",
    "1,20,600:2", "1,20,600:x", "1,20,600::", "1,20,600: 2,3,4:", "0,20,600:", "2,20,600:",
    "12,0,0:", "300,20,600:", "-1,20,600:", "1,-20,600:", "1,20,1100.1:", "1,20,-1:",
    "1,0,600:", "1,0.001,600:", "1,44641,600:", "1,0,600,1:", "1,6554,600,1:",
    "1,99999999999,600:", "1,-7120000,600:", "1,20,7153.6:",
     "1,42949673,600:", "1,20,99999:", "1,20,600:3,20,700:", "1,1e2,600:",
    "1,20,6OO:",
    "1,20,600;", "1,,600:", "1,20,,0:", "1,20,600:2,20,2000:",
    "1,1,1:2,1,2:3,1,3:4,1,4:5,1,5:6,1,6:7,1,7:8,1,8:9,1,9:10,1,10:11,1,11:",
]  # fmt: skip


def test_what_is_not_sound_is_dropped_whole(kiln: Path) -> None:
    said = order(kiln, "13 3", *(f"7 {text}" for text in UNSOUND))
    for text, state in zip(UNSOUND, said.states[1:], strict=False):
        assert state["points"] == "", text


def test_a_gap_is_none_where_there_is_a_segment(kiln: Path) -> None:
    filled = "1/5400/3600,1/6000/1200,2/8000/1500,5/0/0,3/5100/0,"
    assert points(kiln, "7 2,20,600:", place=1) == filled


def test_one_segment_is_changed(kiln: Path) -> None:
    assert (
        points(kiln, "7 3,20,700:", place=1) == "1/5400/3600,4/0/1800,1/7000/1200,5/0/0,3/5100/0,"
    )


def test_the_end_of_before_makes_a_hold(kiln: Path) -> None:
    assert points(kiln, "7 3,20,540:", place=1) == "1/5400/3600,4/0/1800,4/0/1200,5/0/0,3/5100/0,"


def test_one_more_is_put_behind(kiln: Path) -> None:
    assert points(kiln, "7 6,60,50:", place=1) == GIVEN + "1/500/3600,"


def test_the_end_is_moved(kiln: Path) -> None:
    assert points(kiln, "7 3,0,0:", place=1) == "1/5400/3600,4/0/1800,"
    assert points(kiln, "7 1,0,0:", place=1) == ""
    assert points(kiln, "7 6,0,0:", place=1) == GIVEN
    assert points(kiln, "7 7,0,0:", place=1) == GIVEN


def test_what_was_taken_away_does_not_come_back(kiln: Path) -> None:
    assert points(kiln, "7 2,0,0:", "7 4,1,1:", place=1) == "1/5400/3600,"


def test_all_places_are_filled_and_the_end_may_be_said(kiln: Path) -> None:
    ten = "".join(f"{number},1,{100 + number}:" for number in range(1, 11))
    assert points(kiln, f"7 {ten}11,0,0:").count(",") == 10


def test_a_change_outlives_a_look_at_another_program(kiln: Path) -> None:
    said = order(kiln, "13 3", "7 1,20,600:", "14 new", "13 1", "13 3")
    assert (said.state["name"], said.state["points"]) == ("new", "1/6000/1200,")


def test_a_name_without_segments_is_not_kept(kiln: Path) -> None:
    said = order(kiln, "13 3", "14 new", "13 1", "13 3")
    assert (said.state["name"], said.state["points"]) == ("", "")


def test_the_program_that_runs_is_not_changed(kiln: Path) -> None:
    said = order(kiln, "8 1", "7 1,0,0:", "18", "18", "18")
    assert (said.state["points"], said.state["state"], said.state["segment"]) == ("", "1", "4")
