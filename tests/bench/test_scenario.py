import pytest

from heatwright.sim.scenario import Action, actions, end_s
from heatwright.spec import Event, ProgramOrder, Write


def events(*lines):
    return [Event.model_validate(line) for line in lines]


def test_each_press_is_down_and_up():
    found = actions(events({"at": "10 s", "press": "up", "times": 2}, {"for": "1 min"}))
    assert found == (
        Action(10.0, "up"),
        Action(10.1, None),
        Action(10.2, "up"),
        Action(pytest.approx(10.3), None),
    )


def test_an_event_waits_for_the_hand_to_be_free():
    found = actions(
        events({"at": "1 s", "press": "up", "times": 3}, {"at": "1.2 s", "press": "select"})
    )
    assert found[6] == Action(pytest.approx(1.6), "select")


def test_events_are_done_in_the_order_of_their_times():
    found = actions(events({"at": "5 s", "press": "up"}, {"at": "1 s", "press": "down"}))
    assert [action.key for action in found] == ["down", None, "up", None]


def test_the_end_is_the_for():
    assert end_s(events({"at": "1 s", "press": "up"}, {"for": "30 min"})) == 1800


def test_a_scenario_without_an_end_is_refused():
    with pytest.raises(ValueError, match="needs its end"):
        end_s(events({"at": "1 s", "press": "up"}))


def test_lines_and_feeds_are_done_at_their_times():
    found = actions(
        events(
            {"at": "9 s", "extrude": "5 mm/s"},
            {"at": "1 s", "send": "M104 S200"},
            {"at": "1 s", "press": "up"},
        )
    )
    assert found == (
        Action(1.0, line="M104 S200"),
        Action(1.0, "up"),
        Action(1.1),
        Action(9.0, extrude_mm_per_s=5.0),
    )
    assert [action.text for action in found] == ["M104 S200", "up", None, "extrude 5 mm/s"]


@pytest.mark.parametrize(
    ("line", "disturbs"),
    [("M104 S200", False), ("M106 P0 S255", True), ("m107", True), ("G1 E5 F300", True)],
)
def test_a_fan_and_a_feed_happen_to_the_machine(line, disturbs):
    assert Action(0.0, line=line).disturbs is disturbs


def test_a_feed_from_outside_happens_to_the_machine():
    assert Action(0.0, extrude_mm_per_s=0.0).disturbs
    assert not Action(0.0, "up").disturbs


def test_a_master_writes_one_value_after_the_other():
    found = actions(events({"at": "2 s", "write": {"air.setpoint": "60 °C", "air.enabled": True}}))
    assert found == (
        Action(2.0, write=Write("air.setpoint", 60.0)),
        Action(2.0, write=Write("air.enabled", True)),
    )
    assert [action.text for action in found] == ["air.setpoint = 60", "air.enabled = on"]
    assert not any(action.disturbs for action in found)


@pytest.mark.parametrize(
    ("said", "order", "text"),
    [
        ("start 2", ProgramOrder("start", 2), "start 2"),
        ("pause", ProgramOrder("pause"), "pause"),
        ("jump 3", ProgramOrder("jump", 3), "jump 3"),
    ],
)
def test_a_program_is_ordered_about(said, order, text):
    (found,) = actions(events({"at": "3 s", "program": said}))
    assert (found.time_s, found.program, found.text, found.disturbs) == (3.0, order, text, False)
