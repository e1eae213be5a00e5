"""Programs by keys: started, paused, skipped, ended, changed, kept."""

import pytest
from menu_desk import MenuDesk

IDLE, RUNNING, PAUSED, RETURNING = 0, 1, 2, 3
STOPPED = 2
SEGMENTS = 6
SECOND_TARGET_C = 260.0
"""Of the example's program."""
NAME_LENGTH = 12
RISE_K = 4.0
"""In a second: slower than the protection `rise_rate`."""


def started(desk: MenuDesk) -> None:
    desk.press("right", "right", "select", "select")
    desk.run(1.2)


def test_the_first_screen_tells_temperature_setpoint_and_that_nothing_runs(desk: MenuDesk) -> None:
    assert desk.lines == ("20°C >20°C", "off")


def test_a_program_is_started_by_two_selects(desk: MenuDesk) -> None:
    assert desk.press("right", "right") == ("Start program?", "1 anneal")
    assert desk.press("select") == ("SELECT: start", "1 anneal")
    desk.run(1.2)
    assert desk.program("state") == IDLE
    desk.press("select")
    desk.run(1.2)
    assert (desk.program("state"), desk.program("number")) == (RUNNING, 1)
    assert desk.press("left", "left") == ("20°C >20°C", "1/6 runs")


@pytest.mark.parametrize("key", ["left", "right", "up", "down"])
def test_any_other_key_takes_the_first_select_back(desk: MenuDesk, key: str) -> None:
    desk.press("right", "right", "select", key)
    desk.press("left" if key == "right" else "right" if key == "left" else "up")
    desk.press("select")
    desk.run(1.2)
    assert desk.program("state") == IDLE


def test_an_empty_place_cannot_be_started(desk: MenuDesk) -> None:
    desk.press("right", "right", "up")
    assert desk.lines == ("Start program?", "2 (empty)")
    assert desk.press("select", "select") == ("not possible", "2 (empty)")
    desk.run(1.2)
    assert desk.program("state") == IDLE


def test_a_pause_is_one_select_away_and_so_is_the_way_back(desk: MenuDesk) -> None:
    started(desk)
    assert desk.lines == ("Program:", "pause")
    desk.press("select")
    desk.run(1.2)
    assert desk.program("state") == PAUSED
    assert desk.lines == ("Program:", "resume")
    assert desk.press("left", "left")[1] == "1/6 paused"
    desk.press("right", "right", "select")
    desk.run(0.3)
    desk.run(1.2)
    assert desk.program("state") in (RUNNING, RETURNING)


def test_skip_stop_and_go_to_are_asked_for_twice(desk: MenuDesk) -> None:
    started(desk)
    assert desk.press("up") == ("Program:", "skip segment")
    assert desk.press("select") == ("SELECT does it", "skip segment")
    desk.run(1.2)
    assert desk.program("segment") == 1
    desk.press("select")
    desk.run(1.2)
    assert desk.program("segment") == 2
    assert desk.press("up", "up", "up", "up", "up") == ("Program:", "go to 4")
    desk.press("select", "select")
    desk.run(1.2)
    assert desk.program("segment") == 4
    desk.press("left")
    assert desk.press("right", "up", "up") == ("Program:", "stop")
    desk.press("select", "select")
    desk.run(1.2)
    assert (desk.program("state"), desk.program("ended")) == (IDLE, STOPPED)
    assert desk.press("left", "left")[1] == "stopped"


def test_choices_end_with_the_last_segment(desk: MenuDesk) -> None:
    started(desk)
    assert desk.press("down") == ("Program:", f"go to {SEGMENTS}")
    assert desk.press("up") == ("Program:", "pause")


def test_a_program_that_has_ended_in_between_is_not_started_by_who_meant_another(
    desk: MenuDesk,
) -> None:
    """The second SELECT of "skip" meets a machine that is idle by then."""
    started(desk)
    desk.press("up", "select")
    state = desk.device.variables["program.state"]
    desk.device.avr.write_ram(state.address, bytes([IDLE]))
    assert desk.press("select") == ("SELECT: start", "1 anneal")
    desk.run(1.2)
    assert desk.program("state") == IDLE


def test_who_waits_for_the_operator_gets_him_on_the_first_screen(desk: MenuDesk) -> None:
    started(desk)
    desk.press("up", "up", "up", "up", "up", "select", "select")  # go to segment 3
    while desk.felt_c < SECOND_TARGET_C:
        desk.felt_c += RISE_K
        desk.run(1.0)
    desk.run(10.0)
    desk.press("left")
    assert desk.press("left")[1] == "3/6 SELECT: on"
    desk.press("select")
    desk.run(1.2)
    assert desk.program("segment") == 4


def test_times_are_shown_in_days_hours_and_minutes(desk: MenuDesk) -> None:
    started(desk)
    clock = desk.device.variables["program.clock"]
    desk.device.avr.write_ram(clock.address, (93_784).to_bytes(4, "little"))
    desk.run(1.0)
    assert desk.press("left") == ("All  1d02h03m", "Seg. 0d00h00m")


def test_a_changed_program_is_kept_through_a_loss_of_power(desk: MenuDesk) -> None:
    assert desk.press("right", "right", "right") == ("Edit program?", "1 anneal")
    assert desk.press("select") == ("Name, letter 1", "[anneal      ]")
    assert desk.press("up") == ("Name, letter 1", "[bnneal      ]")
    assert desk.press(*["right"] * NAME_LENGTH) == ("Segment 1", "ramp at a rate")
    assert desk.press("right") == ("Segment 1", "to 200°C")
    assert desk.press("up", "up", "down") == ("Segment 1", "to 201°C")
    assert desk.press("right") == ("Segment 1", "300 K/h")
    assert desk.press("down") == ("Segment 1", "299 K/h")
    assert desk.press("right") == ("Segment 2", "fast as it can")
    assert desk.press("up") == ("Segment 2", "hold a time")
    assert desk.press("right") == ("Segment 2", "60 min")
    assert desk.press("select") == ("SELECT: save", "LEFT: back")
    assert desk.press("select")[1] == "1 bnneal"
    desk.power_cycle()
    desk.press("right", "right", "right", "select", "select")
    assert desk.lines == ("Segment 1", "ramp at a rate")
    assert desk.press("right") == ("Segment 1", "to 201°C")
    assert desk.press("right") == ("Segment 1", "299 K/h")
    assert desk.press("right") == ("Segment 2", "hold a time")
    assert desk.press("right") == ("Segment 2", "60 min")


def test_what_is_not_saved_is_not_kept(desk: MenuDesk) -> None:
    desk.press("right", "right", "right", "select", "up", "left")
    assert desk.lines == ("Edit program?", "1 anneal")
    desk.press("select", "select", "right", "up", "select")
    assert desk.lines == ("SELECT: save", "LEFT: back")
    assert desk.press("left") == ("Segment 1", "to 201°C")


def test_a_new_program_is_written_from_nothing_and_runs(desk: MenuDesk) -> None:
    desk.press("right", "right", "right", "up")
    assert desk.press("select") == ("Name, letter 1", "[new         ]")
    assert desk.press("select") == ("Segment 1", "end")
    assert desk.press("up") == ("Segment 1", "ramp in a time")
    assert desk.press("right") == ("Segment 1", "to 0°C")
    desk.hold("up", 5.0)
    assert desk.lines[1].startswith("to ")
    assert desk.press("right") == ("Segment 1", "60 min")
    assert desk.press("right") == ("Segment 2", "end")
    assert desk.press("down") == ("Segment 2", "hold for SELECT")
    desk.press("select", "select")
    desk.run(2.0)
    assert desk.lines == ("Edit program?", "2 new")
    desk.press("left", "up", "select", "select")
    desk.run(1.2)
    assert (desk.program("state"), desk.program("number"), desk.program("segments")) == (
        RUNNING,
        2,
        2,
    )


def test_a_program_is_not_started_as_it_was_before_it_is_saved(desk: MenuDesk) -> None:
    desk.press("right", "right", "right", "select", "select", "right", "up", "select")
    desk.device.press("select")
    desk.run(0.03)
    desk.device.press(None)
    desk.run(0.03)
    for key in ("left", "select", "select"):
        desk.device.press(key)
        desk.run(0.03)
        desk.device.press(None)
        desk.run(0.03)
    desk.run(0.1)
    assert desk.lines[0] == "not possible"
    desk.run(2.0)
    assert desk.program("state") == IDLE
    desk.press("up", "down", "select", "select")
    desk.run(1.2)
    assert (desk.program("state"), desk.program("to_dc")) == (RUNNING, 2010)


def test_end_in_the_middle_cuts_what_follows_off(desk: MenuDesk) -> None:
    desk.press("right", "right", "right", "select", "select", "right", "right", "right")
    assert desk.lines == ("Segment 2", "fast as it can")
    assert desk.press("down", "down", "down") == ("Segment 2", "end")
    assert desk.press("right") == ("Segment 2", "end")
    desk.press("select", "select")
    desk.run(2.0)
    desk.press("left", "select", "select")
    desk.run(1.2)
    assert desk.program("segments") == 1


def test_a_running_program_is_not_changed_by_what_is_saved(desk: MenuDesk) -> None:
    started(desk)
    to_dc = desk.program("to_dc")
    desk.press("right", "select", "select", "right", "up", "select", "select")
    desk.run(2.0)
    assert desk.program("to_dc") == to_dc
