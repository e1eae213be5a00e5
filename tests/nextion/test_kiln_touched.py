"""Every order of the display, given by touching its pages, on the binary."""

import pytest
from kiln_desk import IDLE, PAUSED, RETURNING, RUNNING, KilnDesk

from heatwright.spec.nextion import display_pages

K, S = 3, 6
"""Codes of thermocouples (MAX31856 data sheet, configuration register 1)."""
SAVED_S = 30.0
"""Settings are kept within this time after they were changed."""


def start(desk: KilnDesk) -> None:
    desk.tap("bprog", "s1")
    assert desk.read("program.state") == RUNNING


@pytest.fixture
def running(desk: KilnDesk) -> KilnDesk:
    start(desk)
    return desk


def loop(desk: KilnDesk, member: str) -> float:
    return float(desk.read(f"loop_chamber.{member}"))


# -- programs --------------------------------------------------------------------------------------


def test_8_a_program_is_started(running: KilnDesk) -> None:
    assert running.display.page == "main"
    running.run(5.0)
    assert running.read("program.number") == 1
    assert loop(running, "enabled") == 1


def test_8_an_empty_place_is_not(desk: KilnDesk) -> None:
    desk.tap("bprog", "s2")
    desk.run(2.0)
    assert desk.read("program.state") == IDLE


def test_9_it_is_paused_and_goes_on(running: KilnDesk) -> None:
    running.run(10.0)
    running.tap("bt1")
    running.run(2.0)
    assert running.read("program.state") == PAUSED
    assert loop(running, "enabled") == 0
    assert running.shows("bt1.val") == 0
    running.tap("bt1")
    running.run(2.0)
    assert running.read("program.state") in (RETURNING, RUNNING)


def test_10_go_here(running: KilnDesk) -> None:
    running.tap("bpoints", "g3")
    running.run(2.0)
    assert running.display.page == "main"
    assert running.read("program.segment") == 3
    assert running.read("program.state") == RETURNING
    assert running.shows("point.val") == 3


def test_11_a_segment_is_marked(desk: KilnDesk) -> None:
    desk.tap("bprog", "b1")
    desk.run(1.0)
    before = [desk.shows(f"p{row}.bco") for row in range(1, 11)]
    desk.tap("p4")
    desk.run(1.0)
    after = [desk.shows(f"p{row}.bco") for row in range(1, 11)]
    assert [row for row in range(10) if before[row] != after[row]] == [3]


def test_13_and_7_a_segment_is_changed(desk: KilnDesk) -> None:
    desk.tap("bprog", "b1")
    desk.run(1.0)
    desk.tap("t1")
    assert desk.display.page == "point"
    assert [desk.shows(f"{field}.txt") for field in "kmt"] == ["min", "60", "540"]
    desk.tap("t", "clear", "d3", "d10", "d10", "d9", "d4", "m", "less", "less", "d2", "ok")
    desk.run(2.0)
    assert desk.display.page == "points"
    assert [desk.shows(f"{column}1.txt") for column in "kmt"] == ["min", "9", "400.5"]


@pytest.mark.parametrize(
    ("kind", "amount", "target", "shown"),
    [
        ("k1", "150", "600", ["K/h", "150", "600"]),
        ("k2", "", "600", ["fast", "", "600"]),
        ("k3", "", "", ["until", "", ""]),
        ("k4", "12", "", ["hold", "12", ""]),
    ],
)
def test_7_all_forms_of_segments(
    desk: KilnDesk, kind: str, amount: str, target: str, shown: list[str]
) -> None:
    keys = {key: f"d{place}" for place, key in enumerate("789456123.0-")}
    desk.tap("bprog", "b1")
    desk.run(1.0)
    desk.tap("t8", kind, "m", "clear", *(keys[digit] for digit in amount))
    desk.tap("t", "clear", *(keys[digit] for digit in target), "ok")
    desk.run(2.0)
    assert [desk.shows(f"{column}8.txt") for column in "kmt"] == shown


def test_7_a_program_is_written_and_kept(desk: KilnDesk) -> None:
    """The source's own example, into an empty place; it is there after a power cut."""
    desk.tap("bprog", "b2")
    desk.run(1.0)
    desk.display.send("#7 1,20,600:2,40,300:3,60,300:4,0,0:;")
    desk.tap("pname", "c00", "c11", "space", "c39", "ok")
    desk.run(10.0)
    assert desk.shows("pname.txt") == "al 9"
    desk.power_cycle()
    desk.tap("bprog")
    desk.run(1.0)
    assert desk.shows("name2.txt") == "al 9"
    desk.tap("b2")
    desk.run(1.5)
    rows = [[desk.shows(f"{column}{row}.txt") for column in "kmt"] for row in range(1, 5)]
    assert rows[:2] == [["min", "20", "600"], ["min", "40", "300"]]
    assert rows[2][:2] == ["hold", "60"]
    assert rows[3] == ["", "", ""]
    desk.tap("back", "bprog", "s2")
    desk.run(2.0)
    assert (desk.read("program.state"), desk.read("program.number")) == (RUNNING, 2)
    assert desk.read("program.segments") == 3


def test_7_the_end_of_a_program_is_moved(desk: KilnDesk) -> None:
    desk.tap("bprog", "b1")
    desk.run(1.0)
    desk.tap("t5", "end")
    desk.run(2.0)
    assert [desk.shows(f"k{row}.txt") for row in (4, 5, 6)] == ["hold", "", ""]


def test_17_a_stop_is_asked_for(running: KilnDesk) -> None:
    running.tap("bstop", "no")
    assert running.read("program.state") == RUNNING
    running.tap("bstop", "yes")
    running.run(1.0)
    assert running.read("program.state") == IDLE
    assert loop(running, "enabled") == 0
    assert running.display.page == "main"


def test_18_the_operator_goes_on(running: KilnDesk) -> None:
    running.run(3.0)
    running.tap("bskip")
    running.run(2.0)
    assert running.read("program.segment") == 2


# -- the loop --------------------------------------------------------------------------------------


def test_2_the_loop_is_switched(desk: KilnDesk) -> None:
    desk.tap("bdebug", "on")
    desk.run(2.0)
    assert loop(desk, "enabled") == 1
    assert desk.shows("on.val") == 1
    desk.tap("on")
    desk.run(2.0)
    assert loop(desk, "enabled") == 0
    assert desk.shows("on.val") == 0


def test_3_the_setpoint(desk: KilnDesk) -> None:
    desk.tap("bset", "bsp")
    desk.enter("321.5")
    desk.run(2.0)
    assert desk.display.page == "settings"
    assert desk.read("settings.chamber_setpoint_c") == 321.5
    assert float(desk.shows("sp.txt")) == 321.5


def test_4_the_output_by_hand(desk: KilnDesk) -> None:
    desk.tap("bdebug", "on", "bot")
    desk.enter("42")
    desk.run(3.0)
    assert desk.display.page == "debug"
    assert loop(desk, "duty_percent") == 42
    assert desk.shows("ot.val") == 42
    desk.display.send("#2 1;")
    desk.run(3.0)
    assert loop(desk, "duty_percent") != 42


@pytest.mark.parametrize(("button", "gain"), [("bkp", "kp"), ("bki", "ki"), ("bkd", "kd")])
def test_5_6_19_and_22_gains_are_set_and_kept(desk: KilnDesk, button: str, gain: str) -> None:
    desk.tap("bdebug", button)
    desk.enter("1.25")
    desk.run(1.0)
    assert desk.read(f"settings.chamber_{gain}") == 1.25
    assert float(desk.shows(f"{gain}.txt")) == 1.25
    desk.tap("keep")
    desk.run(SAVED_S)
    desk.power_cycle()
    assert desk.read(f"settings.chamber_{gain}") == 1.25


def test_20_the_critical_temperature(desk: KilnDesk) -> None:
    desk.tap("bset", "bcrit")
    desk.enter("900")
    desk.run(SAVED_S)
    assert desk.read("settings.chamber_maximum_c") == 900
    desk.tap("bcrit")
    desk.enter("1200")
    desk.run(2.0)
    assert desk.read("settings.chamber_maximum_c") == 900, "it is only ever lowered"
    desk.power_cycle()
    assert desk.read("settings.chamber_maximum_c") == 900


def test_15_the_thermocouple(desk: KilnDesk) -> None:
    assert desk.read("settings.chamber_thermocouple") == K
    desk.device.sensors["chamber"].wire = "S"
    desk.tap("bset", "btype", "typeS")
    desk.run(2.0)
    assert desk.read("settings.chamber_thermocouple") == S
    assert desk.shows("thermo.type.txt") == "S"
    desk.run(SAVED_S)
    desk.power_cycle()
    assert desk.read("settings.chamber_thermocouple") == S


def test_15_not_while_a_program_runs(running: KilnDesk) -> None:
    running.tap("bset", "btype", "typeS")
    running.run(2.0)
    assert running.read("settings.chamber_thermocouple") == K


# -- faults ----------------------------------------------------------------------------------------


def test_12_and_16_a_fault_its_page_the_list_the_acknowledgement(running: KilnDesk) -> None:
    running.run(5.0)
    running.device.sensors["chamber"].faults.open = True
    running.run(10.0)
    assert running.read("fault.code") == 17
    assert running.display.page == "fault17"
    assert running.read("program.state") == IDLE
    running.tap("list")
    assert running.display.page == "faults"
    running.run(1.0)
    assert "17" in str(running.shows("l1.txt"))
    running.device.sensors["chamber"].faults.open = False
    running.run(5.0)
    running.tap("ack")
    running.run(2.0)
    assert running.read("fault.code") == 0
    running.tap("back")
    assert running.display.page == "main"
    assert running.shows("ERROR.en") == 0


def test_21_the_board_knows_the_page(desk: KilnDesk) -> None:
    pages = [page.name for page in display_pages(desk.controller)]
    for way in (["bprog"], ["back", "bset"], ["back", "bdebug"], ["back", "bfaults"], ["back"]):
        desk.tap(*way)
        assert desk.read("pages_shown") == pages.index(desk.display.page)
