"""What the display is told: at its start, when something changes, and never too often."""

import random
from itertools import pairwise
from pathlib import Path

import pytest
from display_model import screens
from hosted_kiln import PAGE, Said, received, run

EVERY_TICKS = 2
REFRESH_TICKS = 3000
TRY_TICKS = 200


def after(said: Said, tick: int, begins: str = "") -> list[str]:
    told = zip(said.instructions, said.ticks, strict=True)
    return [text for text, at in told if at >= tick and text.startswith(begins)]


def names(told: list[str]) -> set[str]:
    return {text.split("=")[0] for text in told}


def test_a_change_is_said_and_nothing_else(hosted: Path) -> None:
    said = run(hosted, "5 s; celsius 300; 10 s")
    assert said.instructions[:2] == ["bkcmd=0", "sendme"]
    port = [said.state[each] for each in ("form", "divisor", "speed")]
    assert port == ["6", "16", "2"]  # 8N1, 117 647 baud
    assert after(said, 501) == ["main.temp.val=300"]


def test_no_instruction_follows_another_in_less_than_20_ms(hosted: Path) -> None:
    touches = 20 * ["order 2 1; 3 ticks; order 12; 1 ticks; page points; 1 s"]
    said = run(hosted, "1 s", *touches, "fault 24; 40 s")
    assert min(b - a for a, b in pairwise(said.ticks)) == EVERY_TICKS


def test_everything_again_every_30_s(hosted: Path) -> None:
    said = run(hosted, "61 s")
    first = said.instructions[: said.instructions.index("main.duty.val=0") + 1]
    for start in (REFRESH_TICKS, 2 * REFRESH_TICKS):
        again = after(said, start)
        assert again[:2] == ["bkcmd=0", "sendme"]
        assert names(first[2:]) <= names(again)


OTHERS = {2400: 832, 4800: 416, 9600: 207, 19_200: 103, 31_250: 63, 38_400: 51, 57_600: 34,
          230_400: 8, 250_000: 7, 256_000: 7, 512_000: 3}  # fmt: skip
"""Divisors of the speeds that a display can have and this board, too, but for the line's own."""


def test_a_display_that_does_not_answer_is_looked_for_at_all_speeds(hosted: Path) -> None:
    """Three seconds after it was asked, that is all over; and again with what is said every 30 s.
    At its own speed all is said anew then."""
    said = run(hosted, "display 0; 40 s")
    told = list(zip(said.instructions, said.divisors, said.ticks, strict=True))
    searched = [(divisor, tick) for text, divisor, tick in told if text == "bauds=115200"]
    assert [divisor for divisor, _ in searched] == 2 * list(OTHERS.values())
    ticks = [tick for _, tick in searched]
    assert ticks[0] == pytest.approx(302, abs=EVERY_TICKS)  # three bytes at 2400 baud come first
    assert ticks[len(OTHERS)] == pytest.approx(ticks[0] + REFRESH_TICKS + 300, abs=EVERY_TICKS)
    assert {divisor for text, divisor, _ in told if text not in {"bauds=115200", ""}} == {16}
    behind = [text for text, _, tick in told if tick > ticks[len(OTHERS) - 1] and text]
    assert behind[:3] == ["bkcmd=0", "sendme", "main.temp.val=20"]
    assert run(hosted, "40 s").instructions.count("bauds=115200") == 0


@pytest.mark.parametrize("what", ["page points; 5 s; started", "5 s; lost"])
def test_everything_again_when_the_display_starts_or_has_lost_something(
    hosted: Path, what: str
) -> None:
    said = run(hosted, f"5 s; {what}; 5 s")
    assert after(said, 1000)[:3] == ["bkcmd=0", "sendme", "main.temp.val=20"]
    assert said.state["page"] == "0"


def test_the_display_answers_which_page_it_shows(hosted: Path) -> None:
    said = run(hosted, "5 s", received(b"\x66\x03\xff\xff\xff"), "5 s")
    assert (said.state["page"], said.shown["points.k1.txt"]) == ("3", "time")
    said = run(hosted, "5 s; page faults; 5 s", received(b"\x66\0\xff\xff\xff"), "5 s")
    assert said.state["page"] == "0"
    assert names(after(said, 0, "main.")) <= names(after(said, 1000))


@pytest.mark.parametrize("answer", [b"\x66\xc8\xff\xff\xff", b"\x66\x03\xff\xff#", b"\xff" * 12,
                                    b"\x1a\xff\xff\xff", b"\0\xff\xff\xff",
                                    b"\x05\0\0\xff\xff\xff", b"\0\x05\0\xff\xff\xff",
                                    b"\0\0\x05\xff\xff\xff", b"\x66\x03ab\xff",
                                    b"\x66\x03a\xff\xff", b"\x66\x03\xffa\xff",
                                    b"\x66\0\xff\xff\xff"])  # fmt: skip
def test_other_answers_mean_nothing(hosted: Path, answer: bytes) -> None:
    said = run(hosted, "5 s", received(answer), "5 s")
    assert said.state["page"] == "0"
    assert after(said, 500) == []


TIMES = {60: "0d 00:01", 599: "0d 00:09", 600: "0d 00:10", 35_999: "0d 09:59", 36_000: "0d 10:00",
         86_399: "0d 23:59", 86_400: "1d 00:00", 863_999: "9d 23:59"}  # fmt: skip
ALARM, ERROR = "main.alarm.txt", "main.ERROR.en"
SEEN = "fault 6; 20 ticks; page fault06"
SHOWN: dict[str, dict[str, str | int]] = {
    "order 8 2; 3 s": {"main.pname.txt": "slump"},
    # A button is put right if its order was refused.
    "3 s; order 9 1; 3 s": {"main.bt1.val=0": 2},
    # The count of control steps wraps, and the display goes on.
    "page debug; 3 s; steps 65533; 5 s; order 3 77; 4 s": {"debug.sp.txt": "77.0"},
    # A page is ordered for who asks for it, until he sees another, and not for who is refused.
    "3 s; order 13 2; 20 ticks; page settings; 10 s": {"page points": 1},
    "3 s; order 13 9; 1 s": {"page points": 0},
    # That of a fault is not ordered again once it is seen, but when the display starts.
    "3 s; fault 6; 20 ticks; page main; 10 s": {"page fault06": 3},
    "3 s; fault 6; 60 s": {"page fault06": 9},
    "3 s; fault 255; 60 s": {"page faults": 9},
    f"3 s; {SEEN}; 10 s": {"page fault06": 1, "t.txt": "20.0"},
    f"3 s; {SEEN}; 3 s; page main; 3 s; started; 1 s": {"page fault06": 2},
    "page faults; 3 s; fault 6; 20 s": {
        "page fault06": 3, "faults.l1.txt": "E06 TOO HOT  20.0 C  0d 00:00"},
    "3 s; fault 9; 9 ticks; page main; 2 s": {"page main": 1, ALARM: "E09", ERROR: "1"},
    f"3 s; {SEEN}; page main; 2 s": {ALARM: "E06 TOO HOT", ERROR: "1"},
    # After the acknowledgement the main page comes, and begins anew: it may just have lit its
    # alarm, and nobody else would put it out. Who looks at the list goes on with that.
    f"3 s; {SEEN}; order 16; 1 s; page main; 2 s": {"page main": 1, ERROR: "0", ALARM: ""},
    f"3 s; {SEEN}; page main; 3 s; order 16; 1 s": {"page main": 1},
    f"3 s; {SEEN}; page faults; 3 s; order 16; 1 s": {"page main": 0},
    # On a slow line the fault's page answers only when the main page has been ordered.
    "3 s; fault 6; 9 ticks; trips 0; order 16; 9 ticks; page fault06; 9 ticks": {'t.txt="20.0"': 0},
}  # fmt: skip
"""What happens after two seconds, and what is shown then, or how often something was told."""


@pytest.mark.parametrize("what", SHOWN)
def test_it_shows(hosted: Path, what: str) -> None:
    said = run(hosted, "2 s", what)
    for name, expected in SHOWN[what].items():
        if isinstance(expected, int):
            assert said.instructions.count(name) == expected, name
        else:
            assert said.shown[name] == expected, name


ORDERS = """2 1|2 0|4 35.5|16|17|8 1|8 2|8 3|9 0|9 1|10 2|10 3|18|5 9.5|6 0.000125|19 10|6 123.4567
|19 999.5|5 1000.25|6 12345.68|5 99999|19 123456|5 1000000|19 0|3 0.05|3 640|20 999.5|5 9.123456
|6 10.12345|19 999.1234|5 1000.678|6 99999.25|19 100000.7|11 10|11 0|11 1|13 1|13 3|14 a-b|15 6
|15 3|7 1,0.9,700:|7 2,2.02,0:3,150.5,-0,1:|7 1,0,0:|7 3,20,600:"""
STARTS = """2 1; 1 s; order 4 35.5|8 1; 1 s; order 9 0|8 1; 1 s; order 18; 1 s; order 18
|8 1; 1 s; order 10 5; 3 s|8 1; 1 s; order 10 3; 1 s; celsius 800; 3 s; order 18|8 1|8 2|2 1"""
DOES = (*(f"order {each.strip()}" for each in f"{ORDERS}|{STARTS}".split("|")), "celsius -39",
        "celsius 20", "celsius 490", "passed 59", "passed 183600", "passed 899999",
        *(f"fault {code}; 1 s; trips 0; page {page}"
          for code, page in ((24, "main"), (6, "fault06"), (18, "fault18"))))  # fmt: skip
PAGES = (*3 * ("main",), "points", "programs", "settings", "debug", "thermo", "fault06", "stop")


def test_each_page_shows_how_things_stand(hosted: Path) -> None:
    """All that a page shows, whatever has happened: it was told since the page began."""
    chance = random.Random(9)  # noqa: S311 - no secret
    acknowledged = ("", "order 16; 1 s; ")
    steps = [
        (chance.choice(acknowledged) + chance.choice(DOES), chance.choice(PAGES))
        for _ in range(1200)
    ]
    lasts = (f"{chance.choice((2, 3, 5, 40))} s; look; page {page}; 3 s; look" for _, page in steps)
    texts = (f"{what}; {last}" for (what, _), last in zip(steps, lasts, strict=True))
    said = run(hosted, "99 ticks; 1 s; look", *texts)
    names = {1: "fuse", 2: "slump", 3: "-"}
    for number, (_, page) in enumerate(steps, 1):
        state = said.states[2 * number]
        first, last = said.counts[2 * number - 1 : 2 * number + 1]
        told = dict(text.split("=", 1) for text in said.instructions[first:last] if "=" in text)
        shown = {name: value.strip('"') for name, value in told.items() if name.startswith(page)}
        names[int(state["shown"])] = state["name"] if state["points"] else "-"
        if page == "main":
            shown["main.alarm.txt"] = shown["main.alarm.txt"][:3]
        expected = screens(state, names)
        told_of_it = {
            name: value for name, value in expected.items() if name.startswith(f"{page}.")
        }
        assert shown == told_of_it, (number, steps[number - 1])
        charted(said.instructions[first:last], page)
        if said.states[2 * number - 1]["page"] == said.states[2 * number - 2]["page"] != "0":
            before = said.counts[2 * number - 2]
            assert not any(text[:3] == "cle" for text in said.instructions[before:first])


def charted(told: list[str], page: str) -> None:
    """From a page's beginning: only its own chart, of each column the two channels in turns."""
    chart = {"main": 24, "debug": 7}.get(page)
    added = [text.rpartition(",")[0] for text in told if text.startswith("add ")]
    assert added == [f"add {chart},{place % 2}" for place in range(len(added))]
    assert not any(text.startswith("cle ") for text in told)
    assert page in {"main", "debug"} or not added


@pytest.mark.parametrize("page", [name for name in PAGE if name[5:].isdigit()])
def test_each_fault_has_its_page(hosted: Path, page: str) -> None:
    code = page.removeprefix("fault")
    said = run(hosted, f"1 s; fault {int(code)}; 9 ticks; page {page}; 1 s; page main; 1 s")
    assert after(said, 0, "page ") == [f"page {page}"]
    assert said.shown[ALARM].startswith(f"E{code} ")


def test_a_page_that_goes_is_told_nothing(hosted: Path) -> None:
    """Until the other one is seen, or was ordered often enough."""
    said = run(hosted, "5 s; fault 6; 4 ticks; celsius 300; 8 s")
    told = after(said, 500)
    assert told[:3] == 3 * ["page fault06"]
    assert "main.temp.val=300" in told[3:]
    first, second, third = said.ticks[-len(told) :][:3]
    assert TRY_TICKS / 2 <= second - first <= TRY_TICKS
    assert third - second == TRY_TICKS
    seen = run(hosted, "5 s; fault 6; 1 s; page fault06; 2 s")
    assert after(seen, 500) == ["page fault06", 't.txt="20.0"']


def test_the_list_of_faults(hosted: Path) -> None:
    trips = [f"fault {code}; 61 s; trips 0; order 16; 1 s" for code in (1, 6, *[24] * 7)]
    said = run(hosted, "1 s", *trips, "order 12; 5 ticks; page faults; 2 s")
    assert "page faults" in said.instructions
    listed = [said.shown[f"faults.l{row}.txt"] for row in range(1, 9)]
    assert listed[0] == "E24  20.0 C  0d 00:08"
    assert [line[:3] for line in listed] == ["E24"] * 7 + ["E06"]
    trips = [f"clock {time_s}; fault 6; 9 ticks; trips 0; order 16; 9 ticks" for time_s in TIMES]
    said = run(hosted, "1 s", *trips, "page faults; 3 s")
    listed = [said.shown[f"faults.l{row}.txt"] for row in range(8, 0, -1)]
    assert listed == [f"E06 TOO HOT  20.0 C  {shown}" for shown in TIMES.values()]


def test_the_same_fault_again_is_listed_again(hosted: Path) -> None:
    """It is acknowledged in the tick of the step that trips it again: ticks 100, 200, 300."""
    said = run(hosted, "celsius 1160; 299 ticks; order 16; 1 ticks; page faults; 8 s")
    assert [said.shown[f"faults.l{row}.txt"][:3] for row in (1, 2, 3)] == ["E06", "E06", ""]


def drawn(said: Said, channel: str, tick: int = 0) -> list[int]:
    points = [text.removeprefix(f"add {channel},") for text in after(said, tick, f"add {channel},")]
    assert all(str(int(point)) == point for point in points)
    return [int(point) for point in points]


def test_the_chart_of_the_firing(hosted: Path) -> None:
    said = run(hosted, "1 s; order 8 1; 1200 s; page points; 600 s; page main; 5 s")
    assert after(said, 0, "cle") == ["cle 24,0", "cle 24,1"]
    temperatures, setpoints = (drawn(said, f"24,{channel}", 180_100) for channel in (0, 1))
    assert temperatures == 31 * [3]  # one a minute, from its start: 20 °C of 1200 in 180 pixels
    # From 20 °C to 540 °C in an hour: half way after 30 minutes.
    assert (len(setpoints), setpoints[0]) == (31, 3)
    assert setpoints[-1] == round((20 + 260) * 180 / 1200)
    again = "order 17; 2 s; order 8 2; 90 s; page points; 1 s; page main; 5 s"
    assert len(drawn(run(hosted, "1 s; order 8 1; 300 s", again), "24,0", 39_400)) == 2


def test_a_firing_clears_the_chart_of_the_one_before_it(hosted: Path) -> None:
    """However much of that one is drawn: its first column comes within two seconds."""
    for ticks in range(9):
        again = f"order 17; 2 s; page points; 1 s; page main; {ticks} ticks; order 8 2; 3 s"
        said = run(hosted, "1 s; order 8 1; 3600 s; look", again)
        cleared = said.instructions.index("cle 24,0", said.counts[0])
        told = [text for text in said.instructions[cleared:] if text[:3] in {"cle", "add"}]
        assert told == ["cle 24,0", "cle 24,1", "add 24,0,3", "add 24,1,3"]


def test_each_column_of_the_running_chart_is_begun_anew_with_its_page(hosted: Path) -> None:
    """Wherever between two of its channels the page went: 100 visits, each 3 ticks later."""
    visit = "page debug; 101 ticks; page main; 2 ticks; look; page debug; 2 s; look"
    said = run(hosted, *100 * [visit])
    for first, last in zip(said.counts[::2], said.counts[1::2], strict=False):
        charted(said.instructions[first:last], "debug")


@pytest.mark.parametrize(
    ("celsius", "pixels"),
    [(600, 90), (604, 91), (1192, 179), (1300, 180), (1800, 180), (-30, 0)],
)
def test_the_running_chart(hosted: Path, celsius: int, pixels: int) -> None:
    """A point a second, until the page of a fault comes; it ends at its edges."""
    said = run(hosted, f"5 s; celsius {celsius}; page debug; 10 s")
    assert 9 <= len(drawn(said, "7,0")) <= 11 or said.state["fault"] == "6"
    assert drawn(said, "7,0")[-1] == pixels
    assert drawn(said, "24", 520) == []


def test_a_chart_that_is_full_loses_its_beginning(hosted: Path) -> None:
    """Ten hours are 600 columns; the eleventh hour takes the place of the first."""
    begins = "celsius 1100; page points; 120 s; celsius 20; 35880 s"
    said = run(hosted, begins, "celsius 1000; 3600 s; page main; 30 s")
    assert drawn(said, "24,0") == 540 * [3] + 60 * [150]
    # In turns with the page's other parts.
    assert [text[:3] for text in after(said, 3_960_000)[2:8]] == 3 * ["add", "mai"]
