import pytest
from machines import events

from heatwright.sim.scenario import Action, actions, end_s
from heatwright.spec import ProgramOrder, Write

MINUTE = {"for": "1 min"}


def up(at_s, **more):
    return {"at": f"{at_s} s", "press": "up", **more}


@pytest.mark.parametrize(
    ("lines", "expected", "texts"),
    [
        # Each press is down and up.
        ([up(10, times=2), MINUTE],
         [Action(10.0, "up"), Action(10.1), Action(10.2, "up"), Action(10.3)],
         ["up", None, "up", None]),
        # An event waits for the hand to be free.
        ([up(1, times=2), {"at": "1.2 s", "press": "select"}],
         [Action(1.0, "up"), Action(1.1), Action(1.2, "up"), Action(1.3), Action(1.4, "select"),
          Action(1.5)],
         ["up", None, "up", None, "select", None]),
        # Events are done in the order of their times.
        ([up(5), {"at": "1 s", "press": "down"}],
         [Action(1.0, "down"), Action(1.1), Action(5.0, "up"), Action(5.1)],
         ["down", None, "up", None]),
        ([{"at": "9 s", "extrude": "5 mm/s"}, {"at": "1 s", "send": "M104 S200"}, up(1)],
         [Action(1.0, line="M104 S200"), Action(1.0, "up"), Action(1.1),
          Action(9.0, extrude_mm_per_s=5.0)],
         ["M104 S200", "up", None, "extrude 5 mm/s"]),
        # A master writes one value after the other.
        ([{"at": "2 s", "write": {"air.setpoint": "60 °C", "air.enabled": True}}],
         [Action(2.0, write=Write("air.setpoint", 60.0)),
          Action(2.0, write=Write("air.enabled", True))],
         ["air.setpoint = 60", "air.enabled = on"]),
        *(([{"at": "3 s", "program": said}],
           [Action(3.0, program=ProgramOrder(*order))], [said])
          for said, order in (
              ("start 2", ("start", 2)), ("pause", ("pause",)), ("jump 3", ("jump", 3)))),
    ],
)  # fmt: skip
def test_what_is_done_when(lines, expected, texts):
    found = actions(events(*lines))
    times_s = [each.time_s for each in expected]
    assert [each.time_s for each in found] == pytest.approx(times_s)
    assert [each._replace(time_s=0.0) for each in found] == [
        each._replace(time_s=0.0) for each in expected
    ]
    assert [each.text for each in found] == texts


def test_the_end_is_the_for():
    assert end_s(events(up(1), {"for": "30 min"})) == 1800
    with pytest.raises(ValueError, match="needs its end"):
        end_s(events(up(1)))


def test_a_fan_and_a_feed_happen_to_the_machine():
    quiet = [Action(0.0, line="M104 S200"), Action(0.0, "up")]
    quiet += [Action(0.0, write=Write("air.setpoint", 60.0))]
    quiet += [Action(0.0, program=ProgramOrder("pause"))]
    felt = [Action(0.0, line=line) for line in ("M106 P0 S255", "m107", "G1 E5 F300")]
    felt += [Action(0.0, extrude_mm_per_s=0.0)]
    assert [each.disturbs for each in quiet + felt] == [False] * 4 + [True] * 4
