"""Order 7: segments put in, changed, taken away; all that was sent, or nothing."""

from pathlib import Path

import pytest
from hosted_kiln import order

GIVEN = "1/5400/3600,4/0/1800,2/8000/1500,5/0/0,3/5100/0,"
"""Kind, tenths of a degree, seconds or tenths of a kelvin per hour."""
TEN = "".join(f"{number},1,{100 + number}:" for number in range(1, 11))
KINDS = {
    "1,20,600:2,40,300:3,60,300:4,0,0:": "1/6000/1200,1/3000/2400,4/0/3600,",  # of the source
    "1,20,600,0:": "1/6000/1200,",
    "1,150,600,1:": "2/6000/1500,",
    "1,150.25,600,1:": "2/6000/1503,",
    "1,0,600,2:": "3/6000/0,",
    "1,0,0,2:": "3/0/0,",
    "1,0,0,3:": "5/0/0,",
    "1,5,600,3:": "5/0/0,",
    "1,5,600,4:": "4/0/300,",
    "1,0.02,600:": "1/6000/1,",
    "1,2.02,600.04:": "1/6000/121,",
    "1,2.016,600.05:": "1/6001/121,",
    "1,44640,600:": "1/6000/2678400,",
    "1,2.01,600.049:": "1/6000/121,",
    "1,.5,1100:": "1/11000/30,",
    "1,5,-0:": "1/0/300,",
    TEN + "11,0,0:": "".join(f"1/{1000 + 10 * number}/60," for number in range(1, 11)),
}
"""Into an empty place: what is sent, and what is there then."""
CHANGES = {
    ("2,20,600:",): "1/5400/3600,1/6000/1200,2/8000/1500,5/0/0,3/5100/0,",
    ("3,20,700:",): "1/5400/3600,4/0/1800,1/7000/1200,5/0/0,3/5100/0,",
    ("3,20,540:",): "1/5400/3600,4/0/1800,4/0/1200,5/0/0,3/5100/0,",
    ("6,60,50:",): GIVEN + "1/500/3600,",
    ("3,0,0:",): "1/5400/3600,4/0/1800,",
    ("1,0,0:",): "",
    ("6,0,0:",): GIVEN,
    ("7,0,0:",): GIVEN,
    ("2,0,0:", "4,1,1:"): "1/5400/3600,",
}
"""Of a program that is there: a gap would be one in an empty place; the target of before makes a
hold; what was taken away does not come back."""
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


SENT = [
    *(("13 3", (text,), left) for text, left in KINDS.items()),
    *(("13 1", texts, left) for texts, left in CHANGES.items()),
]


@pytest.mark.parametrize(("place", "texts", "left"), SENT)
def test_a_program_is_changed(hosted: Path, place: str, texts: tuple[str, ...], left: str) -> None:
    assert order(hosted, place, *(f"7 {text}" for text in texts)).state["points"] == left


def test_what_is_not_sound_is_dropped_whole(hosted: Path) -> None:
    said = order(hosted, "13 3", *(f"7 {text}" for text in UNSOUND))
    for text, state in zip(UNSOUND, said.states[1:], strict=False):
        assert state["points"] == "", text


@pytest.mark.parametrize(
    ("orders", "kept"),
    [(["7 1,20,600:", "14 new"], ("new", "1/6000/1200,")), (["14 new"], ("", ""))],
)
def test_a_change_outlives_a_look_at_another_program(
    hosted: Path, orders: list[str], kept: tuple[str, str]
) -> None:
    """A name without segments does not."""
    said = order(hosted, "13 3", *orders, "13 1", "13 3")
    assert (said.state["name"], said.state["points"]) == kept


def test_the_program_that_runs_is_not_changed(hosted: Path) -> None:
    said = order(hosted, "8 1", "7 1,0,0:", "18", "18", "18")
    assert (said.state["points"], said.state["state"], said.state["segment"]) == ("", "1", "4")
