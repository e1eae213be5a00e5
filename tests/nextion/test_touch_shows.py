"""What the display is told: at its start, when something changes, and never too often."""

from itertools import pairwise
from pathlib import Path

import pytest
from hosted_kiln import (
    LOOK,
    PAGE,
    STARTED,
    TOUCHED,
    Said,
    celsius,
    fault,
    ordered,
    received,
    run,
    seconds,
    ticks,
)

from heatwright.spec.nextion import Component, display_pages

EVERY_TICKS = 2
REFRESH_TICKS = 3000
TRY_TICKS = 200


def page(name: str) -> bytes:
    """The display says that it shows a page."""
    return ordered(f"21 {PAGE[name]}")


def after(said: Said, tick: int) -> list[str]:
    return [text for text, at in zip(said.instructions, said.ticks, strict=True) if at >= tick]


def test_it_begins_with_silence_about_answers(hosted: Path) -> None:
    said = run(hosted, seconds(1))
    assert said.instructions[:2] == ["bkcmd=0", "sendme"]


def test_a_change_is_said_and_nothing_else(hosted: Path) -> None:
    said = run(hosted, seconds(5), celsius(300), seconds(10))
    assert after(said, 501) == ["main.temp.val=300"]


def test_no_instruction_follows_another_in_less_than_20_ms(hosted: Path) -> None:
    touches = [
        ordered("2 1") + ticks(3),
        ordered("12") + ticks(1),
        page("points") + seconds(1),
    ] * 20
    said = run(hosted, seconds(1), *touches, fault(24), seconds(40))
    assert min(b - a for a, b in pairwise(said.ticks)) == EVERY_TICKS


def test_everything_again_every_30_s(hosted: Path) -> None:
    said = run(hosted, seconds(61))
    first = said.instructions[: said.instructions.index("main.duty.val=0") + 1]
    for start in (REFRESH_TICKS, 2 * REFRESH_TICKS):
        again = after(said, start)
        assert again[:2] == ["bkcmd=0", "sendme"]
        assert {text.split("=")[0] for text in first[2:]} <= {text.split("=")[0] for text in again}


def test_everything_again_when_the_display_starts(hosted: Path) -> None:
    said = run(hosted, seconds(5), page("points"), seconds(5), received(STARTED), seconds(5))
    again = after(said, 1000)
    assert again[:3] == ["bkcmd=0", "sendme", "main.temp.val=20"]
    assert said.state["page"] == "0"


def test_everything_again_when_the_display_has_lost_something(hosted: Path) -> None:
    said = run(hosted, seconds(5), received(b"\x24\xff\xff\xff"), seconds(5))
    assert after(said, 500)[:3] == ["bkcmd=0", "sendme", "main.temp.val=20"]


def test_the_display_answers_which_page_it_shows(hosted: Path) -> None:
    said = run(hosted, seconds(5), received(b"\x66\x03\xff\xff\xff"), seconds(5))
    assert said.state["page"] == "3"
    assert said.shown["points.k1.txt"] == "min"
    faults = page("faults")
    said = run(hosted, seconds(5), faults, seconds(5), received(b"\x66\0\xff\xff\xff"), seconds(5))
    assert said.state["page"] == "0"
    told = {text.split("=")[0] for text in after(said, 1000)}
    assert {text.split("=")[0] for text in said.instructions if text.startswith("main.")} <= told


@pytest.mark.parametrize("answer", [b"\x66\xc8\xff\xff\xff", b"\x66\x03\xff\xff#", b"\xff" * 12,
                                    b"\x1a\xff\xff\xff", b"\0\xff\xff\xff",
                                    b"\x66\x03ab\xff"])  # fmt: skip
def test_other_answers_mean_nothing(hosted: Path, answer: bytes) -> None:
    said = run(hosted, seconds(5), received(answer), seconds(5))
    assert said.state["page"] == "0"
    assert after(said, 500) == []


def test_a_page_shows_its_own_and_all_of_it(hosted: Path) -> None:
    """Whatever begins empty, or 0 in a field, and is not set by the page's own code, is said."""
    for name in ("main", "programs", "points", "settings", "thermo", "debug", "faults"):
        said = run(hosted, ordered("3 640"), seconds(2), page(name), seconds(3))
        told = {text.split("=")[0] for text in after(said, 200)}
        assert all(text.startswith((f"{name}.", "add ")) for text in told)
        parts = display_pages(TOUCHED)[PAGE[name]].components
        missing = {part.name for part in parts if _waits(part)} - {
            text.split(".")[1] for text in told if "." in text
        }
        assert missing == set(), name


def _waits(part: Component) -> bool:
    begins = part.attributes.get("val", part.attributes.get("txt"))
    return part.kind in ("text", "number") and begins in ("", 0)


def rows(*shown: str) -> dict[str, str]:
    """What the page of a program shows, row by row: kind, amount, target; - for nothing."""
    return {
        f"points.{column}{number}.txt": text.strip("-")
        for number, row in enumerate(shown, 1)
        for column, text in zip("kmt", row.split(), strict=True)
    }


SHOWN = {
    "a program": (
        [ordered("13 1"), page("points"), seconds(3)],
        rows("min 60 540", "hold 30 -", "K/h 150 800", "until - -", "fast - 510", "- - -")
        | {"points.pname.txt": "fuse"},
    ),
    "fractions as they are typed": (
        [ordered("13 3"), ordered("7 1,2.02,600.5:2,150.5,-0,1:3,0.5,700:"), seconds(1),
         page("points"), seconds(3)],
        rows("min 2.02 600.5", "K/h 150.5 0", "min 0.5 700"),
    ),
    "what was taken away no more": (
        [page("points"), seconds(3), ordered("7 3,0,0:"), seconds(3)],
        rows("min 60 540", "hold 30 -", "- - -"),
    ),
    "off": ([seconds(3)], {"main.state.txt": "off"}),
    "on": ([ordered("2 1"), seconds(3)], {"main.state.txt": "on"}),
    "by hand": ([ordered("2 1", "4 5"), seconds(3)], {"main.state.txt": "by hand"}),
    "running": ([ordered("8 1"), seconds(3)], {"main.state.txt": "runs"}),
    "paused": ([ordered("8 1"), seconds(2), ordered("9 0"), seconds(3)],
               {"main.state.txt": "paused"}),
    "going back": ([ordered("8 1"), seconds(2), ordered("10 3"), seconds(3)],
                   {"main.state.txt": "returns to its setpoint"}),
    "stopped": ([ordered("8 1"), seconds(2), ordered("17"), seconds(3)],
                {"main.state.txt": "stopped"}),
    "stopped by a fault": (
        [ordered("8 1"), seconds(2), fault(24), ticks(9), page("main"), seconds(3)],
        {"main.state.txt": "stopped by a fault"},
    ),
    "below zero": ([celsius(-30), seconds(5)], {"main.temp.val": "-30"}),
    "a fault without a page": (
        [fault(9), ticks(9), page("main"), seconds(2)],
        {"main.alarm.txt": "E09 FROZEN", "main.ERROR.en": "1"},
    ),
}  # fmt: skip
"""What happens after two seconds, and what is shown then."""


@pytest.mark.parametrize("name", SHOWN)
def test_it_shows(hosted: Path, name: str) -> None:
    script, expected = SHOWN[name]
    shown = run(hosted, seconds(2), *script).shown
    assert {attribute: shown[attribute] for attribute in expected} == expected


def test_marks_are_shown(hosted: Path) -> None:
    said = run(hosted, seconds(1), ordered("8 1"), seconds(2), ordered("11 4"), page("points"),
        seconds(3),
    )  # fmt: skip
    colours = [said.shown[f"points.p{row}.bco"] for row in range(1, 6)]
    assert len(set(colours)) == 3
    assert colours[1] == colours[2] == colours[4]


def test_clocks_and_energy(hosted: Path) -> None:
    """Half full power for two minutes over an hour: the clocks count, the meter too."""
    said = run(hosted, seconds(2), ordered("8 1"), *[seconds(600)] * 7)
    shown = said.shown
    assert [shown[f"main.{name}.val"] for name in ("day", "hour1", "minute1")] == ["0", "1", "9"]
    assert [shown[f"main.{name}.val"] for name in ("day2", "hour2", "minute2")] == ["0", "1", "9"]
    kwh = float(shown["main.energy.txt"].removesuffix(" kWh"))
    assert 0 < kwh <= 0.484 * 4202 / 3600 + 0.005


def test_a_fault_has_its_page(hosted: Path) -> None:
    said = run(hosted, seconds(5), fault(6), seconds(1), page("fault06"), seconds(2), page("main"),
        seconds(2),
    )  # fmt: skip
    told = after(said, 500)
    assert told[:2] == ["page fault06", 't.txt="20.0"']
    assert {"main.ERROR.en=1", 'main.alarm.txt="E06 TOO HOT"'} <= set(told)


def test_a_page_that_goes_is_told_nothing(hosted: Path) -> None:
    """Until the other one is seen, or was ordered often enough."""
    said = run(hosted, seconds(5), fault(6), ticks(4), celsius(300), seconds(8))
    told = after(said, 500)
    assert told[:3] == 3 * ["page fault06"]
    assert "main.temp.val=300" in told[3:]


def test_a_page_that_is_not_seen_is_ordered_again(hosted: Path) -> None:
    said = run(hosted, seconds(5), fault(6), seconds(10))
    times = [at for text, at in zip(said.instructions, said.ticks, strict=True)
             if text == "page fault06"]  # fmt: skip
    assert len(times) == 3
    assert TRY_TICKS / 2 <= times[1] - times[0] <= TRY_TICKS
    assert times[2] - times[1] == TRY_TICKS


SEEN = [fault(6), ticks(20), page("fault06")]
ORDERED = {
    # A page that is seen is not ordered again.
    "its page": ([*SEEN, seconds(10)], "fault06", 1, {"t.txt": "20.0"}),
    "the main page after the acknowledgement": (
        [*SEEN, ordered("16"), seconds(1), page("main"), seconds(2)],
        "main", 1, {"main.ERROR.en": "0", "main.alarm.txt": ""},
    ),
    # It may just have lit its alarm, and nobody else would put it out.
    "the main page anew after the acknowledgement": (
        [*SEEN, page("main"), seconds(3), ordered("16"), seconds(1)], "main", 1, {},
    ),
    "nothing for who looks at the list": (
        [*SEEN, page("faults"), seconds(3), ordered("16"), seconds(1)], "main", 0, {},
    ),
    "its page again when the display starts": (
        [*SEEN, seconds(3), page("main"), seconds(3), received(STARTED), seconds(1)],
        "fault06", 2, {},
    ),
    "the main page where it has none": ([fault(9), ticks(9), page("main"), seconds(2)], "main", 1,
                                        {}),
    "a program that is asked for": ([ordered("13 2"), seconds(1)], "points", 1, {}),
}  # fmt: skip
"""What happens after five seconds, a page, how often it is ordered, and what is shown then."""


@pytest.mark.parametrize("name", ORDERED)
def test_a_page_is_ordered(hosted: Path, name: str) -> None:
    script, ordered_page, times, expected = ORDERED[name]
    said = run(hosted, seconds(5), *script)
    assert said.instructions.count(f"page {ordered_page}") == times
    assert {attribute: said.shown[attribute] for attribute in expected} == expected


def test_the_list_of_faults(hosted: Path) -> None:
    trips = [fault(code) + seconds(61) + ordered("16") + seconds(1) for code in (1, 6, *[24] * 7)]
    said = run(hosted, seconds(1), *trips, ordered("12"), ticks(5), page("faults"),
               seconds(2))  # fmt: skip
    assert "page faults" in said.instructions
    listed = [said.shown[f"faults.l{row}.txt"] for row in range(1, 9)]
    assert listed[0] == "E24 KILN LAGS  20.0 C  0d 00:08"
    assert [line[:3] for line in listed] == ["E24"] * 7 + ["E06"]


def test_the_chart_of_the_firing(hosted: Path) -> None:
    said = run(hosted, seconds(1), ordered("8 1"), *[seconds(600)] * 2, page("points"),
               seconds(600), page("main"), seconds(5))  # fmt: skip
    cleared = [text for text in said.instructions if text.startswith("cle")]
    assert cleared == ["cle 24,0", "cle 24,1"]
    drawn = [text for text in after(said, 100 + 180000) if text.startswith("add 24,")]
    assert len(drawn) == 2 * 31  # one a minute, from its start, both channels
    temperatures = [int(text.split(",")[2]) for text in drawn[::2]]
    setpoints = [int(text.split(",")[2]) for text in drawn[1::2]]
    assert set(temperatures) == {3}  # 20 °C of 1200 in 180 pixels
    # From 20 °C to 540 °C in an hour: half way after 30 minutes.
    assert setpoints[0] == 3
    assert setpoints[-1] == round((20 + 260) * 180 / 1200)


def test_the_running_chart(hosted: Path) -> None:
    said = run(hosted, seconds(5), celsius(600), page("debug"), seconds(10))
    drawn = [text for text in said.instructions if text.startswith("add 7,0,")]
    assert 9 <= len(drawn) <= 11
    assert drawn[-1] == "add 7,0,90"
    assert not any(text.startswith("add 24") for text in after(said, 520))


def test_a_chart_ends_at_its_edges(hosted: Path) -> None:
    for degrees, pixels in ((1300, 180), (1800, 180), (-30, 0)):
        said = run(hosted, seconds(5), celsius(degrees), page("debug"), seconds(20))
        assert [text for text in said.instructions if text.startswith("add 7,0,")][-1] == (
            f"add 7,0,{pixels}"
        )


def test_a_chart_that_is_full_loses_its_beginning(hosted: Path) -> None:
    """Ten hours are 600 columns; the eleventh hour takes the place of the first."""
    away = [page("points"), *[seconds(600)] * 60, celsius(1000), *[seconds(600)] * 6]
    said = run(hosted, *away, page("main"), seconds(30))
    drawn = [text for text in said.instructions if text.startswith("add 24,0,")]
    assert drawn == 540 * ["add 24,0,3"] + 60 * ["add 24,0,150"]


def test_a_button_is_put_right_if_its_order_was_refused(hosted: Path) -> None:
    said = run(hosted, seconds(5), ordered("9 1"), seconds(3))
    assert "main.bt1.val=0" in after(said, 500)


def test_the_same_fault_again_is_listed_again(hosted: Path) -> None:
    """It is acknowledged in the tick of the step that trips it again: ticks 100, 200, 300."""
    hot = celsius(1160) + ticks(299) + ordered("16")
    said = run(hosted, hot, ticks(1), page("faults"), seconds(8))
    listed = [said.shown[f"faults.l{row}.txt"][:3] for row in range(1, 4)]
    assert listed == ["E06", "E06", ""]


def test_the_writes_of_progress_are_counted(hosted: Path) -> None:
    """One at the start, one a minute, one at the segment's end and start."""
    look = page("settings")
    said = run(
        hosted,
        seconds(1),
        look,
        seconds(2),
        ordered("8 1"),
        seconds(100),
        ordered("18"),
        seconds(9),
    )
    told = [text for text in said.instructions if text.startswith("settings.saves.val=")]
    assert list(dict.fromkeys(told)) == [f"settings.saves.val={count}" for count in range(4)]


def test_a_cut_line_changes_nothing(hosted: Path) -> None:
    plain = run(hosted, seconds(3), ordered("8 1"), seconds(100))
    cut = run(hosted, seconds(3), ordered("8 1"), b"x\1", seconds(99), b"x\0", seconds(1), LOOK)
    assert cut.state == plain.state
