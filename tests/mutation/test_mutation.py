"""The engine makes the mutants it says and finds what nobody notices; of a sample nothing lives."""

import os
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest
from mutation import engine
from mutation.court import same_machine_code
from mutation.engine import Engine, cases_of, every_arena, in_order, sampled
from mutation.known import Names, entries, names_of
from mutation.report import Report, protects
from mutation.syntax import TOGETHER, VARIABLE, Kind, mutants_of, schema
from rig.firmware import finished
from suite import SIZE, amount, drawn

SMALL = """\
#include "small.h"
enum { FIRST = 1, SECOND };
static volatile int kept = 3;
int number(int a, int b)
{
    int sum = 0;

    if (a < b && b != 7) {
        sum = a + b * 2;
    } else {
        sum -= ~a;
    }
    for (int i = 0; i < b; i++) {
        sum <<= 1;
        if (i > 3) {
            break;
        }
    }
    switch (a) {
    case FIRST:
        return sum & 12;
    default:
        kept++;
    }
    return a == 5 ? sum : -kept;
}
"""
HEADER = "#define LIMIT 4\nint number(int a, int b);\n"
DRIVER = """\
#include <stdio.h>
#include "small.h"
int main(void)
{
    for (int a = -9; a < 9; a++) {
        for (int b = -9; b < 9; b++) {
            printf("%d ", number(a, b));
        }
    }
    return 0;
}
"""


def said_by(text: str, folder: Path, number: int = 0) -> str:
    for name, content in (("small.c", text), ("small.h", HEADER), ("driver.c", DRIVER)):
        (folder / name).write_text(content, encoding="utf-8")
    subprocess.run(["gcc", "-w", "small.c", "driver.c", "-o", "small"], cwd=folder, check=True)
    command = ["prlimit", "--cpu=1", folder / "small"]
    shown = finished(command, env={**os.environ, VARIABLE: str(number)})
    return f"{shown.returncode} {shown.stdout}"


MUTANTS = mutants_of("small.c", SMALL, names_of({"small.c": SMALL}), order=True)


@pytest.mark.parametrize(
    ("kind", "what"),
    [
        (Kind.STATEMENT, "sum = a + b * 2; -> nothing"), (Kind.STATEMENT, "break; -> nothing"),
        (Kind.STATEMENT, "return sum & 12; -> nothing"),
        (Kind.CONDITION, "if (a < b && b != 7) -> if (!(a < b && b != 7))"),
        (Kind.CONDITION, "if (a < b && b != 7) -> if (1)"),
        (Kind.CONDITION, "if (a < b && b != 7) -> if (0)"), (Kind.CONDITION, "i < b -> 0"),
        (Kind.CONDITION, "return a == 5 ? sum : -kept; -> return 1 ? sum : -kept;"),
        (Kind.EXPRESSION, "if (a < b && b != 7) -> if (a <= b && b != 7)"),
        (Kind.EXPRESSION, "if (a < b && b != 7) -> if (a < b || b != 7)"),
        (Kind.EXPRESSION, "if (a < b && b != 7) -> if (b != 7)"),
        (Kind.EXPRESSION, "sum = a + b * 2; -> sum = a - b * 2;"),
        (Kind.EXPRESSION, "sum = a + b * 2; -> sum = a + b / 2;"),
        (Kind.EXPRESSION, "sum = a + b * 2; -> sum = a + b * 3;"),
        (Kind.EXPRESSION, "sum = a + b * 2; -> sum = a + b * 0;"),
        (Kind.EXPRESSION, "int sum = 0; -> int sum = (-1);"),
        (Kind.EXPRESSION, "sum -= ~a; -> sum += ~a;"),
        (Kind.EXPRESSION, "sum -= ~a; -> sum -= (a);"),
        (Kind.EXPRESSION, "sum <<= 1; -> sum >>= 1;"),
        (Kind.EXPRESSION, "return sum & 12; -> return sum | 12;"),
        (Kind.EXPRESSION, "kept++; -> kept--;"), (Kind.ALONE, "case FIRST: -> nothing"),
        (Kind.ALONE, "FIRST = 1 -> FIRST = 2"),
        (Kind.ALONE, "static volatile int kept = 3; -> static volatile int kept = 4;"),
        (Kind.ORDER, "static volatile int kept = 3; -> static int kept = 3;"),
    ],
)  # fmt: skip
def test_every_operator_makes_its_mutants(kind, what):
    found = {mutant.what: mutant for mutant in MUTANTS}
    assert what in found, "\n".join(sorted(found))
    assert found[what].kind is kind
    assert found[what].applied(SMALL) != SMALL


@pytest.mark.parametrize(
    ("body", "other", "same"),
    [
        ("return u != 0;", "return u > 0;", True),
        ("return NONE == s->m[1];", "return NONE >= s->m[1];", True),
        ("return (i & 1u) == 0;", "return (i & 1u) <= 0;", True),
        ("while (u-- != 0) { f(); }", "while (u-- > 0)", True),
        ("return i != 0;", "return i > 0;", False),
        ("return u != 1;", "return u > 1;", False),
        ("return mixed != 0;", "return mixed > 0;", False),
        ("return SET == u;", "return SET >= u;", False),
        ("for (uint8_t n = 0; n < u && f(); n++) { f(); }", "n != u && f()", True),
        ("for (uint8_t n = 0; n < SET; n++) { f(); }", "n != SET", True),
        ("for (uint8_t n = 0; n < u; n++) { u--; }", "n != u", False),
        ("for (uint8_t n = 0; n < u; n++) { g(&n); }", "n != u", False),
        ("for (uint8_t n = 0; n < i; n++) { f(); }", "n != i", False),
        ("for (uint8_t n = 9; n < SET; n++) { f(); }", "n != SET", False),
        ("for (uint8_t n = 0; n < u || f(); n++) { f(); }", "n != u || f()", False),
    ],
)
def test_what_can_only_be_equal_is_not_asked_for(body, other, same):
    text = f"""\
#define SET 0
enum e {{ NONE, SOME }};
struct s {{ uint8_t m[2]; uint8_t mixed; }};
int f(void);
int g(uint8_t *mixed_up, int mixed);
int h(uint8_t u, struct s *s, int i)
{{
    {body}
}}
"""
    kinds = {each.what.partition(" -> ")[2]: each.kind
             for each in mutants_of("h.c", text, names_of({"h.c": text}))}  # fmt: skip
    assert (kinds[other] is Kind.SAME) is same


def test_no_two_mutants_are_the_same():
    assert len({mutant.identity for mutant in MUTANTS}) == len(MUTANTS)
    assert len({mutant.applied(SMALL) for mutant in MUTANTS}) == len(MUTANTS)


def test_an_atomic_block_can_go_and_is_no_trouble():
    text = "void f(void)\n{\n    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)\n    {\n        a = 1;\n    }\n}"
    made = mutants_of("f.c", text, Names(), order=True)
    (found,) = (each for each in made if each.kind is Kind.ORDER)
    assert found.applied(text) == text.replace("ATOMIC_BLOCK(ATOMIC_RESTORESTATE)", "")
    assert any(mutant.what == "a = 1; -> nothing" for mutant in mutants_of("f.c", text, Names()))


def test_together_each_is_what_it_is_alone(tmp_path):
    together = dict(enumerate((each for each in MUTANTS if each.kind in TOGETHER), 1))
    text = schema(SMALL, together, defines=True)
    original = said_by(SMALL, tmp_path)
    assert said_by(text, tmp_path) == original
    differing = 0
    for number in list(together)[:: max(1, len(together) // amount("schema_mutants"))]:
        (tmp_path / "alone").mkdir(exist_ok=True)
        alone = said_by(together[number].applied(SMALL), tmp_path / "alone")
        assert said_by(text, tmp_path, number) == alone, together[number]
        differing += alone != original
    assert differing


def test_the_same_machine_code_is_told_from_other():
    texts = {"f.c": "int f(int a)\n{\n    return a * 2;\n}\n"}
    assert same_machine_code("f.c", texts, texts["f.c"].replace("a * 2", "a + a"))
    assert not same_machine_code("f.c", texts, texts["f.c"].replace("a * 2", "a * 3"))


@dataclass
class Small:
    expected: str
    compares: bool = True
    name: str = "small/only"
    together: bool = True

    def sources(self) -> Mapping[str, str]:
        return {"small.c": SMALL}

    def headers(self) -> Mapping[str, str]:
        return {"small.h": HEADER}

    def build(self, changed: Mapping[str, str], folder: Path) -> Path:
        said_by(changed.get("small.c", SMALL), folder)
        return folder / "small"

    def prepare(self) -> None:
        pass

    def problem(self, built: Path) -> str:
        shown = finished(["prlimit", "--cpu=1", built], check=True).stdout
        return "it says something else" if self.compares and shown != self.expected else ""


@pytest.mark.parametrize("compares", [True, False])
def test_a_judge_that_looks_kills_and_one_that_does_not_is_told(tmp_path, monkeypatch, compares):
    monkeypatch.setattr(engine, "MEMORY", tmp_path / "memory")
    arena = Small(said_by(SMALL, tmp_path).removeprefix("0 "), compares)
    cases = [case for case in cases_of([arena]) if "sum" in case.mutant.what]
    Engine([arena], cases).run()
    fates = Counter(case.fate for case in cases)
    assert fates["killed" if compares else "survived"] > 0.8 * len(cases)
    monkeypatch.setattr(Small, "problem", None)  # what is known is not judged again
    again = [case for case in cases_of([arena]) if "sum" in case.mutant.what]
    Engine([arena], again).run()
    assert Counter(case.fate for case in again) == fates


def test_a_judge_that_complains_of_the_sound_one_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setattr(engine, "MEMORY", tmp_path)
    arena = Small("something else")
    with pytest.raises(AssertionError, match="the sound firmware has a problem"):
        Engine([arena], cases_of([arena])[:5]).run()


def test_an_entry_without_a_reason_is_an_error():
    assert [entry.reason for entry in entries("# head\na.c f: x -> y : it is so\n")] == ["it is so"]
    with pytest.raises(ValueError, match="no reason"):
        entries("a.c f: x -> y\n")


def test_every_entry_of_the_list_fits_a_mutant():
    arenas = in_order(every_arena())
    assert Report([arena.name for arena in arenas], cases_of(arenas)).unused_entries() == []


ONLY_WHOLE = ("analog", "converters", "indicators", "lcd_keypad/panel", "outputs/burst",
              "outputs/feed", "outputs/held", "outputs/pwm", "outputs/spread", "outputs/switched",
              "outputs/windows", "serial_log")  # fmt: skip
"""Areas of the size "full": on the simulated processor, and of code that does not protect."""


def test_a_sample_is_noticed():
    """Every mutant of code that protects, and 95 % of the others, of which "test" draws none."""
    left_out = () if SIZE == "full" else ONLY_WHOLE
    arenas = [arena for arena in every_arena() if not arena.name.startswith(left_out)]
    names = drawn([arena.name for arena in arenas], min(1, amount("arenas") / len(arenas)))
    few = asked = in_order(arena for arena in arenas if arena.name in names)
    cases = [case for case in cases_of(few) if SIZE != "test" or protects(case.mutant.file)]
    chosen = sampled(cases, amount("mutants"))
    Engine(few, chosen).run()
    alive = {case.mutant.identity for case in chosen if case.fate == "survived"}
    if alive and len(few) < len(arenas):
        asked = in_order(arenas)
        again = [case for case in cases_of(asked) if case.mutant.identity in alive]
        Engine(asked, again).run()
        chosen = [case for case in chosen if case.mutant.identity not in alive] + again
    report = Report([arena.name for arena in asked], chosen)
    sys.stdout.write(f"{Counter(map(report.fate, chosen))}; {report.verdict()}\n")
    assert report.is_well, "\n".join((*report.survivors(), *report.wrong_entries()))
