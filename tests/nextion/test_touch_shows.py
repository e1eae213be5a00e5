"""What the display is told: at its start, when something changes, and never too often."""

from itertools import pairwise
from pathlib import Path

import pytest
from hosted_kiln import PAGE, TOUCHED, Said, received, run

from heatwright.spec.nextion import Component, display_pages

EVERY_TICKS = 2
REFRESH_TICKS = 3000
TRY_TICKS = 200


def after(said: Said, tick: int, begins: str = "") -> list[str]:
    """What was told from a tick on."""
    told = zip(said.instructions, said.ticks, strict=True)
    return [text for text, at in told if at >= tick and text.startswith(begins)]


def names(told: list[str]) -> set[str]:
    """What the instructions set."""
    return {text.split("=")[0] for text in told}


def test_a_change_is_said_and_nothing_else(hosted: Path) -> None:
    said = run(hosted, "5 s; celsius 300; 10 s")
    assert said.instructions[:2] == ["bkcmd=0", "sendme"]
    assert (said.state["form"], said.state["divisor"]) == ("6", "16")  # 8N1, 117 647 baud
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


@pytest.mark.parametrize("what", ["page points; 5 s; started", "5 s; lost"])
def test_everything_again_when_the_display_starts_or_has_lost_something(
    hosted: Path, what: str
) -> None:
    said = run(hosted, f"5 s; {what}; 5 s")
    assert after(said, 1000)[:3] == ["bkcmd=0", "sendme", "main.temp.val=20"]
    assert said.state["page"] == "0"


def test_the_display_answers_which_page_it_shows(hosted: Path) -> None:
    said = run(hosted, "5 s", received(b"\x66\x03\xff\xff\xff"), "5 s")
    assert (said.state["page"], said.shown["points.k1.txt"]) == ("3", "min")
    said = run(hosted, "5 s; page faults; 5 s", received(b"\x66\0\xff\xff\xff"), "5 s")
    assert said.state["page"] == "0"
    assert names(after(said, 0, "main.")) <= names(after(said, 1000))


@pytest.mark.parametrize("answer", [b"\x66\xc8\xff\xff\xff", b"\x66\x03\xff\xff#", b"\xff" * 12,
                                    b"\x1a\xff\xff\xff", b"\0\xff\xff\xff",
                                    b"\x05\0\0\xff\xff\xff", b"\0\x05\0\xff\xff\xff",
                                    b"\0\0\x05\xff\xff\xff", b"\x66\x03ab\xff"])  # fmt: skip
def test_other_answers_mean_nothing(hosted: Path, answer: bytes) -> None:
    said = run(hosted, "5 s", received(answer), "5 s")
    assert said.state["page"] == "0"
    assert after(said, 500) == []


@pytest.mark.parametrize(
    "name", ["main", "programs", "points", "settings", "thermo", "debug", "faults"]
)
def test_a_page_shows_its_own_and_all_of_it(hosted: Path, name: str) -> None:
    """Whatever begins empty, or 0 in a field, and is not set by the page's own code, is said."""
    told = names(after(run(hosted, f"order 3 640; 2 s; page {name}; 3 s"), 200))
    assert all(text.startswith((f"{name}.", "add ")) for text in told)
    waiting = {part.name for part in display_pages(TOUCHED)[PAGE[name]].components if waits(part)}
    assert waiting <= {text.split(".")[1] for text in told if "." in text}


def waits(part: Component) -> bool:
    begins = part.attributes.get("val", part.attributes.get("txt"))
    return part.kind in {"text", "number"} and begins in {"", 0}


def rows(*shown: str) -> dict[str, str]:
    """What the page of a program shows, row by row: kind, amount, target; - for nothing."""
    return {
        f"points.{column}{number}.txt": text.strip("-")
        for number, row in enumerate(shown, 1)
        for column, text in zip("kmt", row.split(), strict=True)
    }


GAINS = ["0", "0.5", "7.6", "9.5", "10", "0.000125", "123.4567", "999.5", "1000.25", "12345.68",
         "99999", "123456", "1000000"]  # fmt: skip
TIMES = {60: "0d 00:01", 599: "0d 00:09", 600: "0d 00:10", 35_999: "0d 09:59", 36_000: "0d 10:00",
         86_399: "0d 23:59", 86_400: "1d 00:00", 863_999: "9d 23:59"}  # fmt: skip
STATE, ALARM, ERROR = "main.state.txt", "main.alarm.txt", "main.ERROR.en"
SEEN = "fault 6; 20 ticks; page fault06"
SHOWN: dict[str, dict[str, str | int]] = {
    "order 13 1; page points; 3 s": {
        **rows("min 60 540", "hold 30 -", "K/h 150 800", "until - -", "fast - 510", "- - -"),
        "points.pname.txt": "fuse",
    },
    # Fractions as they are typed; and what was taken away no more.
    "order 13 3; 1 s; order 7 1,2.02,600.5:2,150.5,-0,1:3,0.5,700:; 1 s; page points; 3 s":
        rows("min 2.02 600.5", "K/h 150.5 0", "min 0.5 700"),
    "page points; 3 s; order 7 3,0,0:; 3 s": rows("min 60 540", "hold 30 -", "- - -"),
    "3 s": {STATE: "off"},
    "order 2 1; 3 s": {STATE: "on"},
    "order 2 1; 1 s; order 4 5; 3 s": {STATE: "by hand"},
    "order 8 1; 3 s": {STATE: "runs"},
    "order 8 1; 200 s": {"main.set.val": "49", "main.duty.val": "100"},
    "order 8 1; 2 s; order 9 0; 3 s": {STATE: "paused"},
    "order 8 1; 2 s; order 10 3; 3 s": {STATE: "returns to its setpoint"},
    "order 8 1; 2 s; order 17; 3 s": {STATE: "stopped"},
    "order 8 1; 2 s; fault 24; 9 ticks; page main; 3 s": {STATE: "stopped by a fault"},
    "celsius -30; 5 s": {"main.temp.val": "-30"},
    # A button is put right if its order was refused.
    "3 s; order 9 1; 3 s": {"main.bt1.val=0": 2},
    "page settings; 3 s": {"settings.sp.txt": "20.0", "settings.crit.txt": "1150.0",
                           "settings.type.txt": "K"},
    "order 15 6; page thermo; 3 s": {"thermo.type.txt": "S"},
    "page debug; 3 s": {"debug.kp.txt": "7.6", "debug.ki.txt": "0.026", "debug.kd.txt": "51"},
    "page programs; 3 s": {"programs.name1.txt": "fuse", "programs.name2.txt": "slump",
                           "programs.name3.txt": "-"},
    # The count of control steps wraps, and the display goes on.
    "page debug; 3 s; steps 65533; 5 s; order 3 77; 4 s": {"debug.sp.txt": "77.0"},
    # A page is ordered for who asks for it, until he sees another, and not for who is refused.
    "3 s; order 13 2; 20 ticks; page settings; 10 s": {"page points": 1},
    "3 s; order 13 9; 1 s": {"page points": 0},
    # That of a fault is not ordered again once it is seen, but when the display starts.
    "3 s; fault 6; 20 ticks; page main; 10 s": {"page fault06": 3},
    f"3 s; {SEEN}; 10 s": {"page fault06": 1, "t.txt": "20.0"},
    f"3 s; {SEEN}; 3 s; page main; 3 s; started; 1 s": {"page fault06": 2},
    "3 s; fault 9; 9 ticks; page main; 2 s": {"page main": 1, ALARM: "E09 FROZEN", ERROR: "1"},
    f"3 s; {SEEN}; page main; 2 s": {ALARM: "E06 TOO HOT", ERROR: "1"},
    # After the acknowledgement the main page comes, and begins anew: it may just have lit its
    # alarm, and nobody else would put it out. Who looks at the list goes on with that.
    f"3 s; {SEEN}; order 16; 1 s; page main; 2 s": {"page main": 1, ERROR: "0", ALARM: ""},
    f"3 s; {SEEN}; page main; 3 s; order 16; 1 s": {"page main": 1},
    f"3 s; {SEEN}; page faults; 3 s; order 16; 1 s": {"page main": 0},
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


def test_gains_are_shown_as_short_as_they_can_be(hosted: Path) -> None:
    said = run(hosted, "1 s; page debug; 2 s", *(f"order 5 {gain}; 2 s" for gain in GAINS))
    told = [text.split('"')[1] for text in after(said, 301, "debug.kp.txt=")]
    assert list(dict.fromkeys(told)) == GAINS


def test_the_rows_that_run_and_are_marked_are_seen(hosted: Path) -> None:
    shown = []
    for before in ("1 s", "1 s; order 8 1; 2 s; order 11 4"):
        said = run(hosted, f"{before}; page points; 3 s").shown
        shown.append([said[f"points.p{row}.bco"] for row in range(1, 11)])
    plain, colours = shown
    assert len(set(plain)) == 1
    assert [row for row in range(10) if colours[row] != plain[row]] == [0, 3]
    assert colours[0] != colours[3]


@pytest.mark.parametrize("page", [name for name in PAGE if name.startswith("fault0")])
def test_each_fault_has_its_page(hosted: Path, page: str) -> None:
    code = page.removeprefix("fault")
    said = run(hosted, f"1 s; fault {int(code)}; 9 ticks; page {page}; 1 s; page main; 1 s")
    assert after(said, 0, "page ") == [f"page {page}"]
    assert said.shown[ALARM].startswith(f"E{code} ")


def test_clocks_and_energy(hosted: Path) -> None:
    """Half full power for two minutes over an hour: the clocks count, the meter too."""
    shown = run(hosted, "2 s; order 8 1; 4200 s").shown
    clocks = ["day", "hour1", "minute1", "day2", "hour2", "minute2"]
    assert [shown[f"main.{name}.val"] for name in clocks] == ["0", "1", "9"] * 2
    kwh = float(shown["main.energy.txt"].removesuffix(" kWh"))
    assert 0 < kwh <= 0.484 * 4202 / 3600 + 0.005


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
    trips = [f"fault {code}; 61 s; order 16; 1 s" for code in (1, 6, *[24] * 7)]
    said = run(hosted, "1 s", *trips, "order 12; 5 ticks; page faults; 2 s")
    assert "page faults" in said.instructions
    listed = [said.shown[f"faults.l{row}.txt"] for row in range(1, 9)]
    assert listed[0] == "E24 KILN LAGS  20.0 C  0d 00:08"
    assert [line[:3] for line in listed] == ["E24"] * 7 + ["E06"]
    trips = [f"clock {time_s}; fault 6; 9 ticks; order 16; 9 ticks" for time_s in TIMES]
    said = run(hosted, "1 s", *trips, "page faults; 3 s")
    listed = [said.shown[f"faults.l{row}.txt"] for row in range(8, 0, -1)]
    assert listed == [f"E06 TOO HOT  20.0 C  {shown}" for shown in TIMES.values()]


def test_the_same_fault_again_is_listed_again(hosted: Path) -> None:
    """It is acknowledged in the tick of the step that trips it again: ticks 100, 200, 300."""
    said = run(hosted, "celsius 1160; 299 ticks; order 16; 1 ticks; page faults; 8 s")
    assert [said.shown[f"faults.l{row}.txt"][:3] for row in (1, 2, 3)] == ["E06", "E06", ""]


def drawn(said: Said, channel: str, tick: int = 0) -> list[int]:
    """The points of a chart, in pixels."""
    return [int(text.split(",")[2]) for text in after(said, tick, f"add {channel},")]


def test_the_chart_of_the_firing(hosted: Path) -> None:
    said = run(hosted, "1 s; order 8 1; 1200 s; page points; 600 s; page main; 5 s")
    assert after(said, 0, "cle") == ["cle 24,0", "cle 24,1"]
    temperatures, setpoints = (drawn(said, f"24,{channel}", 180_100) for channel in (0, 1))
    assert temperatures == 31 * [3]  # one a minute, from its start: 20 °C of 1200 in 180 pixels
    # From 20 °C to 540 °C in an hour: half way after 30 minutes.
    assert (len(setpoints), setpoints[0]) == (31, 3)
    assert setpoints[-1] == round((20 + 260) * 180 / 1200)


@pytest.mark.parametrize(("celsius", "pixels"), [(600, 90), (1300, 180), (1800, 180), (-30, 0)])
def test_the_running_chart(hosted: Path, celsius: int, pixels: int) -> None:
    """A point a second, until the page of a fault comes; it ends at its edges."""
    said = run(hosted, f"5 s; celsius {celsius}; page debug; 10 s")
    assert 9 <= len(drawn(said, "7,0")) <= 11 or said.state["fault"] == "6"
    assert drawn(said, "7,0")[-1] == pixels
    assert drawn(said, "24", 520) == []


def test_a_chart_that_is_full_loses_its_beginning(hosted: Path) -> None:
    """Ten hours are 600 columns; the eleventh hour takes the place of the first."""
    said = run(hosted, "page points; 36000 s; celsius 1000; 3600 s; page main; 30 s")
    assert drawn(said, "24,0") == 540 * [3] + 60 * [150]


def test_the_writes_of_progress_are_counted(hosted: Path) -> None:
    """One at the start, one a minute, one at the segment's end and start."""
    said = run(hosted, "1 s; page settings; 2 s; order 8 1; 100 s; order 18; 9 s")
    told = after(said, 0, "settings.saves.val=")
    assert list(dict.fromkeys(told)) == [f"settings.saves.val={count}" for count in range(4)]


def test_a_cut_line_changes_nothing(hosted: Path) -> None:
    plain = run(hosted, "3 s; order 8 1; 100 s")
    cut = run(hosted, "3 s; order 8 1; cut 1; 99 s; cut 0; 1 s; look")
    assert cut.state == plain.state
