"""Whatever the bytes: a Spec or a SpecError, never anything else."""

import re

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rig.controllers import controllers
from rig.specs import EXAMPLES
from suite import amount

from heatwright.spec import SpecError, load_text

FILES = {file.stem: file.read_bytes() for file in sorted(EXAMPLES.glob("*.yaml"))}
WORDS = [
    b"off", b"1 s", b"-1 K", b"0", b"1e308 s", b"1e-300 K/W", b".inf", b"null", b"true", b"[]",
    b"{}", b"&a", b"*a", b"!!binary x", b"<<", b"|", b">", b"? ", b"---\n", b"...", b"#", b"'",
    b'"', b"\t", b"\x00", b"\xff", b"\xe2\x80\xa8", b"ambient", b"air", b"heater", b"kind: pid",
    b"kind: pwm", b"PD3", b"A7", b"99999 d", b"0.001 W", b"5000 \xc2\xb0C", b"\n  ", b", ", b": ",
]  # fmt: skip


many = settings(max_examples=amount("edited_specs"), suppress_health_check=list(HealthCheck))


def check(data: bytes) -> None:
    try:
        load_text(data)
    except SpecError as error:
        problems = error.problems
    else:
        return
    assert problems
    for problem in problems:
        assert min(problem.line, problem.column) >= 1
        assert str(problem).isprintable()
        assert problem.reason
        assert problem.remedy


@many
@given(st.binary(max_size=400) | st.text(st.characters(codec="utf-8")).map(str.encode))
def test_what_was_never_a_spec(data: bytes) -> None:
    check(data)


good_specs = st.one_of(
    st.sampled_from(list(FILES.values())), controllers().map(lambda drawn: drawn.text.encode())
)
edits = st.lists(
    st.tuples(
        st.floats(0, 1, exclude_max=True),
        st.integers(0, 12),
        st.one_of(st.sampled_from(WORDS), st.binary(max_size=3)),
    ),
    min_size=1,
    max_size=4,
)


@many
@given(good_specs, edits)
def test_edits_of_good_specs(good: bytes, changes: list[tuple[float, int, bytes]]) -> None:
    for where, length, new in changes:
        at = int(where * len(good))
        good = good[:at] + new + good[at + length :]
    check(good)


@many
@given(good_specs, st.data())
def test_other_values_in_good_specs(good: bytes, data: st.DataObject) -> None:
    """Exchange whole values: what is left is well formed, and reaches the checks of physics."""
    lines = good.decode().splitlines()
    values = [
        (number, part) for number, line in enumerate(lines)
        for part in line.replace("{", ",").replace("}", ",").replace("[", ",").split(",")
        if ":" in part and part.split(":", 1)[1].strip()
    ]  # fmt: skip
    for _ in range(data.draw(st.integers(1, 3))):
        number, part = data.draw(st.sampled_from(values))
        _, other = data.draw(st.sampled_from(values))
        new = f"{part.split(':', 1)[0]}:{other.split(':', 1)[1]}"
        lines[number] = lines[number].replace(part, new, 1)
    check("\n".join(lines).encode())


NUMBER = re.compile(r"-?[0-9.]+")
NUMBERS = ["1e-9", "0.001", "0.01", "1", "7", "100", "65536", "1e6", "1e8", "-1", "1e999"]


@many
@given(good_specs, st.data())
def test_other_numbers_in_good_specs(good: bytes, data: st.DataObject) -> None:
    """Exchange numbers and keep their units: the arithmetic of the checks must bear them all."""
    words = good.decode().split(" ")
    places = [i for i, word in enumerate(words) if NUMBER.fullmatch(word.strip("{[\n"))]
    for _ in range(data.draw(st.integers(1, 4))):
        words[data.draw(st.sampled_from(places))] = data.draw(st.sampled_from(NUMBERS))
    check(" ".join(words).encode())


@pytest.mark.parametrize("example", FILES)
def test_every_cut(example: str) -> None:
    """A file cut off anywhere, as by a full disk."""
    for end in range(0, len(FILES[example]), 37):
        check(FILES[example][:end])
