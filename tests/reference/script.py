"""Courses as text: what is done with a machine, line by line, and what it then records.

A course is a title, and below it, indented:

    with KEY: VALUE            what differs in its spec
    20 25*3 -> fault 0         temperatures to be read, 25 three times
    miss 3 *4                  a method of the machine, its arguments, and how often
    not order jump 4           one that must answer no
    setpoint_c = 30            an attribute
    1 2 3 -> duty 100 0*2      as many values as steps: of each; one value: of the last

A value is a number, a word of `WORDS`, `~1` (but for single precision), `<1`, `>1`, or `absent`.
"""

import operator
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from heatwright.sim.reference import copies, inputs, program_state

WORDS = {
    name: value
    for module in (copies, inputs, program_state)
    for name, value in vars(module).items()
    if name.isupper() and isinstance(value, int)
} | {"none": None, "yes": True}
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
    """Parametrise a test with the courses of a file."""
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
    """Do what a line says; return the records of its steps."""
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
