"""Programs by keys: started, paused, skipped, ended, changed, kept."""

import pytest
from menu_desk import IDLE, PAUSED, RETURNING, RUNNING, MenuDesk

STOPPED = 2
SEGMENTS = 6
SECOND_TARGET_C = 260.0
"""Of the example's program."""
NAME = "right " * 12
"""From the first letter of a name to the first segment."""
ASKED = ("Start program?", "1 anneal")
EDIT = "right right right"
"""To the screen that changes programs."""


def started(desk: MenuDesk) -> None:
    desk.press("right", "right", "select", "select")
    desk.run()
    assert desk.program("state") == RUNNING


STATES = [
    ((0, 0, 0), "off"), ((0, 0, 1), "finished"), ((0, 0, 2), "stopped"),
    ((0, 0, 3), "ended by fault"), ((0, 0, 4), "power cut: cold"), ((0, 0, 5), "power cut: lost"),
    ((1, 0, 0), "1/6 runs"), ((1, 1, 0), "1/6 held back"), ((1, 2, 0), "1/6 to target"),
    ((1, 3, 0), "1/6 SELECT: on"), ((2, 0, 0), "1/6 paused"), ((3, 0, 0), "1/6 returning"),
    ((4, 0, 0), "power was cut"),
]  # fmt: skip
"""State, what it waits for, and how the last one ended; and what the first screen says of it."""


@pytest.mark.parametrize(("state", "shown"), STATES)
def test_the_first_screen_tells_temperature_setpoint_and_state(
    desk: MenuDesk, state: tuple[int, int, int], shown: str
) -> None:
    assert desk.lines == ("20°C >20°C", "off")
    desk.put("program.segment", 1)
    desk.put("program.segments", 6)
    desk.put("program.setpoint_c", 321)
    for member, value in zip(("state", "waiting", "ended"), state, strict=True):
        desk.put(f"program.{member}", value)
    setpoint = 321 if state[0] else 20
    desk.walk(("up", f"20°C >{setpoint}°C", shown))  # a key without a use: shown anew


def test_a_program_is_started_by_two_selects(desk: MenuDesk) -> None:
    desk.walk(("right right", *ASKED), ("select", "SELECT: start", "1 anneal"))
    desk.run()
    assert desk.program("state") == IDLE
    desk.press("select")
    desk.run()
    assert (desk.program("state"), desk.program("number")) == (RUNNING, 1)
    desk.walk(("left left", "20°C >20°C", "1/6 runs"))


@pytest.mark.parametrize("keys", ["left right", "right left", "up down", "down up"])
def test_any_other_key_takes_the_first_select_back(desk: MenuDesk, keys: str) -> None:
    desk.walk(("right right select", "SELECT: start", "1 anneal"), (keys, *ASKED))
    desk.press("select")
    desk.run()
    assert desk.program("state") == IDLE


def test_an_empty_place_cannot_be_started(desk: MenuDesk) -> None:
    desk.walk(
        ("right right up", "Start program?", "2 (empty)"),
        ("select select", "not possible", "2 (empty)"),
        ("up", *ASKED),
    )
    desk.run()
    assert desk.program("state") == IDLE


def test_a_pause_is_one_select_away_and_so_is_the_way_back(desk: MenuDesk) -> None:
    started(desk)
    assert desk.lines == ("Program:", "pause")
    desk.press("select")
    desk.run()
    assert desk.program("state") == PAUSED
    assert desk.lines == ("Program:", "resume")
    desk.walk(("left left", "20°C >20°C", "1/6 paused"))
    desk.press("right", "right", "select")
    desk.run(1.5)
    assert desk.program("state") in (RUNNING, RETURNING)


def test_skip_stop_and_go_to_are_asked_for_twice(desk: MenuDesk) -> None:
    started(desk)
    desk.walk(("up", "Program:", "skip segment"), ("select", "SELECT does it", "skip segment"))
    desk.run()
    assert desk.program("segment") == 1
    desk.press("select")
    desk.run()
    assert desk.program("segment") == 2
    desk.walk(("up up up up up", "Program:", "go to 4"))
    desk.press("select", "select")
    desk.run()
    assert desk.program("segment") == 4
    desk.press("left")
    desk.walk(("right up up", "Program:", "stop"))
    desk.press("select", "select")
    desk.run()
    assert (desk.program("state"), desk.program("ended")) == (IDLE, STOPPED)
    assert desk.press("left", "left")[1] == "stopped"


def test_choices_end_with_the_last_segment(desk: MenuDesk) -> None:
    started(desk)
    desk.walk(("down", "Program:", f"go to {SEGMENTS}"), ("up", "Program:", "pause"))


def test_a_program_that_has_ended_in_between_is_not_started_by_who_meant_another(
    desk: MenuDesk,
) -> None:
    """The second SELECT of "skip" meets a machine that is idle by then."""
    started(desk)
    desk.press("up", "select")
    desk.put("program.state", IDLE)
    desk.walk(("select", "SELECT: start", "1 anneal"))
    desk.run()
    assert desk.program("state") == IDLE


def test_who_waits_for_the_operator_gets_him_on_the_first_screen(desk: MenuDesk) -> None:
    started(desk)
    desk.press("up", "up", "up", "up", "up", "select", "select")  # go to segment 3
    desk.warm_to(SECOND_TARGET_C)
    desk.run(10.0)
    desk.press("left")
    assert desk.press("left")[1] == "3/6 SELECT: on"
    desk.press("select")
    desk.run()
    assert desk.program("segment") == 4


@pytest.mark.parametrize(
    ("seconds", "shown"),
    [(93_784, "1d02h03m"), (45_300, "0d12h35m"), (86_340, "0d23h59m"), (86_400, "1d00h00m")],
)
def test_times_are_shown_in_days_hours_and_minutes(
    desk: MenuDesk, seconds: int, shown: str
) -> None:
    started(desk)
    for name, line in (("clock", "All "), ("segment_clock", "Seg.")):
        desk.put("program.segment_clock", 0)
        desk.put(f"program.{name}", seconds)
        desk.run(1.0)
        desk.press("left")
        assert f"{line} {shown}" in desk.lines
        desk.press("right")


def test_what_cannot_be_done_is_refused_until_another_is_chosen(desk: MenuDesk) -> None:
    started(desk)
    desk.press("select")
    desk.run()
    desk.walk(
        ("up", "Program:", "skip segment"),
        ("select select", "not possible", "skip segment"),
        ("up", "Program:", "stop"),
    )
    assert desk.program("state") == PAUSED


def test_a_name_is_of_any_letters_but_those_that_would_end_a_text(desk: MenuDesk) -> None:
    """The display shows an arrow for the last of them."""
    letters = [chr(code) for code in range(0x20, 0x7F) if chr(code) not in '"\\']
    place = letters.index("a")
    desk.press(*EDIT.split(), "select")
    for key, step in (("down", -1), ("up", 1)):
        found = [desk.press(key)[1][1] for _ in letters]
        wanted = [
            letters[(place + step * turn) % len(letters)] for turn in range(1, len(letters) + 1)
        ]
        assert "".join(found) == "".join(wanted).replace("~", "→")


def test_each_kind_begins_with_something_that_works(desk: MenuDesk) -> None:
    kinds = ["ramp in a time", "ramp at a rate", "fast as it can", "hold a time",
             "hold for SELECT", "end"]  # fmt: skip
    desk.press(*EDIT.split(), "up", "select", "select")
    assert [desk.press("up") for _ in kinds] == [("Segment 1", kind) for kind in kinds]
    desk.walk(
        ("up up right", "Segment 1", "to 0°C"),
        ("right", "Segment 1", "100 K/h"),
        ("left left up up right", "Segment 1", "60 min"),
        ("up up down", "Segment 1", "61 min"),
    )
    # A step each tenth of a second after half a second, and ten times as much from the twentieth.
    assert desk.press("up", for_s=4.56)[1] == f"{61 + 1 + 19 + 10 * 22} min"


def test_a_program_has_as_many_segments_as_there_is_room_for(desk: MenuDesk) -> None:
    """From the last place there is no way on; what saves is SELECT and nothing else."""
    desk.press(*EDIT.split(), "up", "select", "select")
    for number in range(1, 9):
        desk.walk(("up", f"Segment {number}", "ramp in a time"))
        last = desk.press("right", "right", "right")
    assert last == ("Segment 8", "60 min")
    save = ("SELECT: save", "LEFT: back")
    desk.walk(("select", *save), ("up right", *save), ("select", "saving", "2 new"))
    desk.run(5.0)
    desk.walk(("up", "Edit program?", "1 anneal"), ("down", "Edit program?", "2 new"))


def test_a_changed_program_is_kept_through_a_loss_of_power(desk: MenuDesk) -> None:
    desk.walk(
        (EDIT, "Edit program?", "1 anneal"),
        ("select", "Name, letter 1", "[anneal      ]"),
        ("up", "Name, letter 1", "[bnneal      ]"),
        (NAME, "Segment 1", "ramp at a rate"),
        ("right", "Segment 1", "to 200°C"),
        ("up up down", "Segment 1", "to 201°C"),
        ("right", "Segment 1", "300 K/h"),
        ("down", "Segment 1", "299 K/h"),
        ("right", "Segment 2", "fast as it can"),
        ("up", "Segment 2", "hold a time"),
        ("right", "Segment 2", "60 min"),
        ("select", "SELECT: save", "LEFT: back"),
    )
    assert desk.press("select")[1] == "1 bnneal"
    desk.power_cycle()
    desk.walk(
        (f"{EDIT} select select", "Segment 1", "ramp at a rate"),
        ("right", "Segment 1", "to 201°C"),
        ("right", "Segment 1", "299 K/h"),
        ("right", "Segment 2", "hold a time"),
        ("right", "Segment 2", "60 min"),
    )


def test_what_is_not_saved_is_not_kept(desk: MenuDesk) -> None:
    desk.walk(
        (f"{EDIT} select up left", "Edit program?", "1 anneal"),
        ("select select right up select", "SELECT: save", "LEFT: back"),
        ("left", "Segment 1", "to 201°C"),
    )


def test_a_new_program_is_written_from_nothing_and_runs(desk: MenuDesk) -> None:
    desk.walk(
        (f"{EDIT} up select", "Name, letter 1", "[new         ]"),
        ("select", "Segment 1", "end"),
        ("up", "Segment 1", "ramp in a time"),
        ("right", "Segment 1", "to 0°C"),
    )
    assert desk.press("up", for_s=5.0)[1].startswith("to ")
    desk.walk(
        ("right", "Segment 1", "60 min"),
        ("right", "Segment 2", "end"),
        ("down", "Segment 2", "hold for SELECT"),
    )
    desk.press("select", "select")
    desk.run(2.0)
    assert desk.lines == ("Edit program?", "2 new")
    desk.press("left", "up", "select", "select")
    desk.run()
    found = [desk.program(member) for member in ("state", "number", "segments")]
    assert found == [RUNNING, 2, 2]


def test_a_program_is_not_started_as_it_was_before_it_is_saved(desk: MenuDesk) -> None:
    desk.press(*EDIT.split(), "select", "select", "right", "up", "select")
    desk.press("select", "left", "select", "select", for_s=0.03)
    desk.run(0.1)
    assert desk.lines[0] == "not possible"
    desk.run(2.0)
    assert desk.program("state") == IDLE
    desk.press("up", "down", "select", "select")
    desk.run()
    assert (desk.program("state"), desk.program("to_dc")) == (RUNNING, 2010)


def test_end_in_the_middle_cuts_what_follows_off(desk: MenuDesk) -> None:
    desk.walk(
        (f"{EDIT} select select right right right", "Segment 2", "fast as it can"),
        ("down down down", "Segment 2", "end"),
        ("right", "Segment 2", "end"),
    )
    desk.press("select", "select")
    desk.run(2.0)
    desk.press("left", "select", "select")
    desk.run()
    assert desk.program("segments") == 1


def test_a_running_program_is_not_changed_by_what_is_saved(desk: MenuDesk) -> None:
    started(desk)
    to_dc = desk.program("to_dc")
    desk.press("right", "select", "select", "right", "up", "select", "select")
    desk.run(2.0)
    assert desk.program("to_dc") == to_dc
