"""What the reference model does, step by step, on courses whose every step is known."""

from typing import Any

import yaml
from reference_machines import Commanded, Kiln, Nozzle, Player, commanded_of, kiln_of, nozzle_of
from script import courses

from heatwright.spec import Algorithm, Frozen, Heating, RisingWhileOff, Runaway, kinds

RULES = {"heating": Heating, "runaway": Runaway, "frozen": Frozen} | {
    "rising_while_off": RisingWhileOff
}
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
