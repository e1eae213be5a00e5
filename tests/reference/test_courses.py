"""What the reference model does, step by step, on courses whose every step is known.

They are text: what is done with a machine, line by line, and what it then records.

A course is a title, and below it, indented:

    with KEY: VALUE            what differs in its spec
    20 25*3 -> fault 0         temperatures to be read, 25 three times
    miss 3 *4                  a method of the machine, its arguments, and how often
    not order jump 4           one that must answer no
    setpoint_c = 30            an attribute
    1 2 3 -> duty 100 0*2      as many values as steps: of each; one value: of the last

A value is a number, a word of `WORDS`, `~1` (but for single precision), `<1`, `>1`, or `absent`.
"""

import math
import operator
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import yaml
from reference_machines import Commanded, Kiln, Nozzle, Player, commanded_of, kiln_of, nozzle_of

from heatwright.sim.reference import inputs
from heatwright.sim.reference.interfaces.nextion import Editor
from heatwright.sim.reference.programs import copies
from heatwright.sim.reference.programs import state as program_state
from heatwright.sim.reference.programs.copies import FAST, HOLD, OVER, RATE, UNTIL, Part
from heatwright.spec import Algorithm, Frozen, Heating, RisingWhileOff, Runaway, kinds
from heatwright.spec.loops import Effort

WORDS = {
    name: value
    for module in (copies, inputs, program_state)
    for name, value in vars(module).items()
    if name.isupper() and isinstance(value, int)
} | {"none": None, "yes": True, "nan": math.nan}
TUNINGS = ("BUSY", "DONE", "TIMED_OUT", "STOPPED_BEFORE", "TOO_HOT", "NO_USE")
WORDS |= {name: number for number, name in enumerate(TUNINGS, 1)}
SHORT = {"fault": "fault.code", "fault_c": "fault.temperature_c", "duty": "duty_percent",
         "on": "enabled", "setpoint": "setpoint_c"}  # fmt: skip
COMPARED = {"<": operator.lt, ">": operator.gt, "~": lambda found, one: found == pytest.approx(one)}


@dataclass(frozen=True)
class Course:
    title: str
    changes: dict[str, str]
    lines: tuple[str, ...]

    def play(self, machine: Any) -> None:
        for line in self.lines:
            deed, _, expected = line.partition(" -> ")
            records = done(machine, deed.split()) or [machine.record]
            for each in filter(None, expected.split(", ")):
                name, *values = each.split()
                found = [member(record, name) for record in records]
                wanted = repeated(values)
                if len(wanted) == 1:
                    found = found[-1:]
                matches = [fits(*pair) for pair in zip(found, wanted, strict=True)]
                assert all(matches), f"{self.title}: {line}: {name} is {found}"


def courses(name: str) -> Any:
    text = (Path(__file__).parent / f"{name}.txt").read_text("utf-8")
    found = []
    for block in re.split(r"\n(?=\S)", text.strip()):
        title, *lines = [line.partition(" # ")[0].strip() for line in block.splitlines()]
        lines = [line for line in lines if line]
        changes = [line[5:].partition(": ") for line in lines if line.startswith("with ")]
        rest = tuple(line for line in lines if not line.startswith("with "))
        found.append(Course(title, {key: value for key, _, value in changes}, rest))
    return pytest.mark.parametrize("course", found, ids=lambda course: course.title)


def repeated(words: list[str]) -> list[str]:
    pairs = [word.partition("*") for word in words]
    return [word for word, _, times in pairs for _ in range(int(times or 1))]


def done(machine: Any, words: list[str]) -> list[Any]:
    if words[0][-1].isdigit():
        return machine.feed_all(map(float, repeated(words)))
    if words[1:2] == ["="]:
        holder, _, name = words[0].rpartition(".")
        setattr(operator.attrgetter(holder)(machine) if holder else machine, name, value(words[2]))
        return []
    refused = words[0] == "not"
    name, *arguments = words[refused:]
    times = int(arguments.pop()[1:]) if arguments and arguments[-1][0] == "*" else 1
    named = dict(each.split("=") for each in arguments if "=" in each)
    values = [value(each) for each in arguments if "=" not in each]
    act = operator.attrgetter(name)(machine)
    answers = [act(*values, **{k: value(v) for k, v in named.items()}) for _ in range(times)]
    if isinstance(answers[0], bool) or refused:
        assert answers == [not refused] * times, words
        return []
    if isinstance(answers[0], list):
        return [record for records in answers for record in records]
    return [record for record in answers if record is not None]


def value(word: str) -> Any:
    if re.fullmatch(r"-?[\d.]+", word):
        return float(word) if "." in word else int(word)
    return WORDS.get(word, word)


def member(record: Any, name: str) -> Any:
    """Give a member of a record, by its last word too."""
    name = SHORT.get(name, name)
    found = [name] if name in record else [key for key in record if key.endswith(f".{name}")]
    assert len(found) <= 1, (name, found)
    return float(record[found[0]]) if found else None


def fits(found: Any, wanted: str) -> bool:
    if wanted == "absent" or found is None:
        return found is None and wanted == "absent"
    if wanted[0] in COMPARED:
        return bool(COMPARED[wanted[0]](found, value(wanted[1:])))
    return bool(found == value(wanted))


RULES = {"heating": Heating, "runaway": Runaway, "frozen": Frozen,
         "rising_while_off": RisingWhileOff, "effort": Effort}  # fmt: skip
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
    with pytest.raises(ValueError, match="no command"):
        kiln.said("M104 S200")


@pytest.mark.parametrize("name", ["other.setpoint", "nozzle.colour", "reboot"])
def test_what_there_is_not_cannot_be_written(name: str) -> None:
    with pytest.raises(KeyError):
        Nozzle().write(name, 1.0)
