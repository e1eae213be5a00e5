"""Many mutants in one C file: the variable `chosen_mutant` says which of them it is, 0 for none.

An expression e with a mutant m becomes `(chosen_mutant == 17 ? (m) : (e))`, a statement that goes
becomes `if (chosen_mutant != 12) { … }`. The number comes from the environment, before anything
else of the program begins: worlds that keep an image of all memory keep it, too. There is room on
both sides of it: a mutant that writes beside an array must not become another one.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence

from mutation.syntax import Kind, Mutant

VARIABLE = "MUTANT"
NAMED = "#define chosen_mutant chosen_mutants[64]\n"
DECLARATION = "extern volatile int chosen_mutants[128];\n" + NAMED
DEFINITION = f"""\
volatile int chosen_mutants[128];
{NAMED}char *getenv(const char *);
int atoi(const char *);
__attribute__((constructor(101))) static void choose_mutant(void)
{{
    const char *const number = getenv("{VARIABLE}");

    chosen_mutant = number ? atoi(number) : 0;
}}
"""
Place = tuple[int, int]
TOGETHER = (Kind.EXPRESSION, Kind.CONDITION, Kind.STATEMENT)


def schema(text: str, mutants: Mapping[int, Mutant], *, defines: bool = False) -> str:
    """Return a file with all these mutants in it, by their numbers from 1 on; one file of a program
    defines the variable."""
    places: dict[Place, list[int]] = defaultdict(list)
    for number, mutant in mutants.items():
        places[mutant.start, mutant.end].append(number)
    ordered = sorted(places, key=lambda place: (place[0], -place[1]))
    body = _Text(text.encode(), mutants, places).part(0, len(text.encode()), ordered)
    return (DEFINITION if defines else DECLARATION) + "#line 1\n" + body.decode()


class _Text:
    def __init__(
        self, data: bytes, mutants: Mapping[int, Mutant], places: Mapping[Place, Sequence[int]]
    ) -> None:
        self._data, self._mutants, self._places = data, mutants, places

    def part(self, start: int, end: int, places: Sequence[Place]) -> bytes:
        """Return a part of the file with its places, which are ordered, the outer ones first."""
        found, here, rest = [], start, list(places)
        while rest:
            first, last = rest.pop(0)
            inner = [place for place in rest if place[1] <= last]
            rest = rest[len(inner) :]
            found += [self._data[here:first], self._chosen(first, last, inner)]
            here = last
        return b"".join([*found, self._data[here:end]])

    def _chosen(self, start: int, end: int, inner: Sequence[Place]) -> bytes:
        plain = self.part(start, end, inner)
        numbers = self._places[start, end]
        kinds = {self._mutants[number].kind for number in numbers}
        if kinds == {Kind.STATEMENT}:
            (number,) = numbers
            return b"{ if (chosen_mutant != %d) { %s } }" % (number, plain)
        if Kind.CONDITION in kinds:
            plain = b"!!(%s)" % plain
        for number in numbers:
            new = self._mutants[number].new.encode()
            plain = b"(chosen_mutant == %d ? (%s) : (%s))" % (number, new, plain)
        return plain
