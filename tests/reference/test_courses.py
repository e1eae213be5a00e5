"""What the reference model does, step by step, on courses whose every step is known."""

from typing import Any

import pytest
import yaml
from reference_machines import Commanded, Kiln, Nozzle, Player, commanded_of, kiln_of, nozzle_of
from script import courses

from heatwright.sim.reference.copies import FAST, HOLD, OVER, RATE, UNTIL, Part
from heatwright.sim.reference.points import Editor
from heatwright.spec import Algorithm, Frozen, Heating, RisingWhileOff, Runaway, kinds

RULES = {"heating": Heating, "runaway": Runaway, "frozen": Frozen,
         "rising_while_off": RisingWhileOff}  # fmt: skip
LOOSE = "frozen: off, rise_rate: 100 K/s, heating: off, runaway: off, rising_while_off: off"


@courses("chamber")
def test_rules_and_algorithms(course: Any, vary: Any) -> None:
    """Each rule alone; it trips at its bound, and not one step or one sensor step before."""
    read = {key: yaml.safe_load(text) for key, text in course.changes.items()}
    parts = {} if read.pop("rules", None) else dict.fromkeys(RULES)
    for key, told in read.items():
        kind = kinds(Algorithm)[told["kind"]] if key == "algorithm" else RULES.get(key)
        parts[key] = kind.model_validate(told) if kind else float(told)
    course.play(Player(vary(**parts)))


@courses("kiln")
def test_programs(course: Any) -> None:
    """With the mean of readings, and what becomes of a program after a loss of power."""
    course.play(Kiln(kiln_of(**course.changes)))


@courses("commanded")
def test_what_a_host_makes_of_a_loop(course: Any) -> None:
    course.play(Commanded(commanded_of(**course.changes)))


@courses("autotune")
def test_the_relay_experiment(course: Any) -> None:
    changes = {"protection": LOOSE} | course.changes
    course.play(Commanded(commanded_of(**changes)))


@courses("nozzle")
def test_switch_cooler_master_and_current(course: Any) -> None:
    course.play(Nozzle(nozzle_of(**course.changes)))


THREE = (Part(OVER, 6000, 1200), Part(OVER, 3000, 2400), Part(HOLD, 0, 3600))
EDITED = {
    "1,90,800,0:": (Part(OVER, 8000, 5400), *THREE[1:]),
    "1,150.5,800,1:": (Part(RATE, 8000, 1505), *THREE[1:]),
    "1,0,800,2:": (Part(FAST, 8000), *THREE[1:]),
    "1,0,0,3:": (Part(UNTIL), *THREE[1:]),
    "1,0.5,0,4:": (Part(HOLD, 0, 30), *THREE[1:]),
    "4,10,20:": (*THREE, Part(OVER, 200, 600)),
    "2,0,0:": THREE[:1],
    # The source's example from nothing: 600 °C in 20 min, 300 °C in 40 min, an hour there.
    "1,0,0:1,20,600:2,40,300:3,60,300:4,0,0:": THREE,
}
UNSOUND = ("5,1,20:", "0,1,20:", "1.5,1,20:", "1,0,20:", "1,1,1001:", "1,1,20,5:", "1,9999,20,1:",
           "1,50000,20:", "x", "1,1:", "1,1,20:9,1,20:")  # fmt: skip


@pytest.mark.parametrize("text", EDITED)
def test_segments_are_put_in_changed_and_taken_away(text: str) -> None:
    assert Editor(kiln_of()).edited(THREE, text) == EDITED[text]


@pytest.mark.parametrize("text", UNSOUND)
def test_what_is_not_sound_is_refused_whole(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        Editor(kiln_of()).edited(THREE, text)


def test_what_is_not_sound_changes_nothing() -> None:
    kiln = Kiln()
    before = dict(kiln.operator.copies)
    kiln.said("#7 1,20,600:7,1,1:;#99 5;#8 x;")
    assert kiln.operator.copies == before
    with pytest.raises(ValueError, match="no order"):
        kiln.said("M104 S200")


@pytest.mark.parametrize("name", ["other.setpoint", "nozzle.colour", "reboot"])
def test_what_there_is_not_cannot_be_written(name: str) -> None:
    with pytest.raises(KeyError):
        Nozzle().write(name, 1.0)
