"""Files become specs or errors that help, whatever their bytes; quantities are read with units."""

import math
import pickle
import re
from decimal import Decimal
from unittest.mock import Mock

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic_core import PydanticCustomError
from rig.controllers import controllers
from rig.firmware import EXAMPLES, changed, example
from suite import amount

from heatwright.spec import Spec, SpecError, digest, load, load_text, units
from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.loading.loader import MOST_PROBLEMS
from heatwright.spec.loading.text import LARGEST_FILE, Unreadable
from heatwright.spec.loading.translate import MOST_WORDED
from heatwright.spec.loading.tree import parse as parse_tree
from heatwright.spec.quantity import QuantityRange, about, duration, parse, rounded_up
from heatwright.spec.units import Dimension

CHAMBER = EXAMPLES / "chamber.yaml"
TEXT = CHAMBER.read_text("utf-8")


@pytest.fixture
def chamber() -> Spec:
    return example("chamber")


def test_line_ends_and_a_byte_order_mark_change_nothing(chamber: Spec) -> None:
    """The line of what was left out is the first, or that of what holds it."""
    assert (chamber.line(("comparison", 3)), chamber.line(())) == (1, 1)
    for text in (TEXT.replace("\n", "\r\n"), TEXT.replace("\n", "\r"), f"\ufeff{TEXT}"):
        spec = load_text(text.encode(), "chamber.yaml")
        assert spec.controller == chamber.controller
        assert spec.line(("safety", "watchdog")) == chamber.line(("safety", "watchdog"))


def test_what_yaml_1_1_would_misread() -> None:
    spec = load_text(TEXT.replace("heating: {rise: 2 K, within: 120 s}", "heating: off"))
    assert spec.controller.loops["air"].protection.heating is None
    with pytest.raises(SpecError, match="'1:30' does not have the unit of a duration"):
        load_text(TEXT.replace("period: 1 s", "period: 1:30"))
    octal = TEXT.replace("baud: 9600", "baud: 0009600")
    assert load_text(octal).controller.interfaces[1].baud == 9600  # type: ignore[union-attr]


def test_the_digest_is_of_what_shapes_the_firmware(chamber: Spec) -> None:
    def other(old: str, new: str) -> str:
        return load_text(changed("chamber", (old, new))).digest

    assert chamber.digest == digest(chamber.controller)
    assert other("# Air heater", "# Heater") == chamber.digest
    assert other("maximum: 85 °C", "maximum: 185 °F") == chamber.digest
    assert other("minimum: -10 °C\n", "\n") == chamber.digest  # the default
    assert other("for: 30 min", "for: 31 min") == chamber.digest
    assert other("maximum: 85 °C", "maximum: 86 °C") != chamber.digest
    assert other("pin: D3", "pin: D2") != chamber.digest
    assert other("title: Air", "title: The air") != chamber.digest


def test_a_spec_never_changes(chamber: Spec) -> None:
    controller = chamber.controller
    with pytest.raises(ValueError, match="frozen"):
        controller.safety.watchdog_s = 1.0  # type: ignore[misc]
    sensors = controller.sensors
    assert isinstance(sensors, ReadOnlyDict)
    for change in (
        lambda: sensors.update(other=1), lambda: sensors.pop("air"),
        lambda: sensors.__setitem__("air", 1), sensors.clear,
    ):  # fmt: skip
        with pytest.raises(TypeError, match="read-only"):
            change()
    assert pickle.loads(pickle.dumps(controller)) == controller  # noqa: S301
    assert hash(controller) == hash(load(CHAMBER).controller)


def test_huge_and_endless_files_are_refused() -> None:
    with pytest.raises(SpecError, match="the file has more than"):
        load_text(b"a" * (LARGEST_FILE + 1))
    with pytest.raises(OSError, match="no regular file"):
        load("/dev/zero")


ABUSE = {
    "a key again": "k: 1\n" * 60_000,
    "many keys": "".join(f"key{number}: 1\n" for number in range(20_000)),
    "aliases": "a: &x [" + "*x, " * 60_000 + "]", "lists in lists": "[" * 250_000,
    "keys in keys": "{a: " * 60_000, "items in items": "- " * 100_000,
    "a long value": "a: " + "x" * 250_000, "a long key": '"' + "\\x41" * 60_000 + '": 1',
    "keys of keys": "? " * 100_000,
    "many sensors": "sensors:\n" + "".join(f" s{n}: {{kind: ds18b20}}\n" for n in range(9000)),
}  # fmt: skip


@pytest.mark.parametrize("way", ABUSE)
def test_abuse_ends_briefly(way: str, monkeypatch: pytest.MonkeyPatch) -> None:
    looked = Mock(return_value=[])
    monkeypatch.setattr("difflib.get_close_matches", looked)
    with pytest.raises(SpecError) as caught:
        load_text(ABUSE[way])
    assert 1 <= len(caught.value.problems) <= MOST_PROBLEMS + 1
    assert len(str(caught.value)) < 50_000
    assert looked.call_count <= MOST_WORDED
    if way == "many keys":
        assert "more problems from here on" in caught.value.problems[-1].reason


@pytest.mark.parametrize("loader", [yaml.BaseLoader, yaml.CBaseLoader])
@pytest.mark.parametrize("text", ["[", "a: b: c", "\x00", "\ud800"])
def test_any_text_that_is_no_yaml_is_unreadable(
    text: str, loader: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("heatwright.spec.loading.tree._Loader", loader)
    with pytest.raises(Unreadable, match="this is not YAML: "):
        parse_tree(text, "spec.yaml")


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
words = st.one_of(st.sampled_from(WORDS), st.binary(max_size=3))
edit = st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 12), words)
edits = st.lists(edit, min_size=1, max_size=4)


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


DIMENSIONS = [value for value in vars(units).values() if isinstance(value, Dimension)]


READ: list[tuple[Dimension, dict[str, float]]] = [
    (units.TEMPERATURE, {
        "50 °C": 50.0, "50C": 50.0, "50 ° C": 50.0, "50 ℃": 50.0, "50\u00a0°C": 50.0,
        "122 °F": 50.0, "-40 F": -40.0, "323.15 K": 50.0, "−10 °C": -10.0, "-0 °C": 0.0,
    }),
    (units.DIFFERENCE, {"2 K": 2.0, "62.5 mK": 0.0625}),
    (units.DURATION, {
        "20 ms": 0.02, "0.1 ms": 0.0001, "64 us": 0.000064, "64 µs": 0.000064, "64 μs": 0.000064,
        "1.5 min": 90.0, "2 h": 7200.0, "1 d": 86400.0,
    }),
    (units.POWER, {"240 W": 240.0, "2.4kW": 2400.0, "1e3 W": 1000.0}),
    (units.FREQUENCY, {"16 MHz": 16e6, "1 kHz": 1000.0}), (units.RATE, {"6 K/min": 0.1}),
    (units.PERCENT, {"80 %": 80.0}), (units.BITS, {"12bit": 12.0, "12 bits": 12.0}),
    (units.CAPACITY, {"4.5 kJ/K": 4500.0}), (units.THERMAL_RESISTANCE, {"0.173 K / W": 0.173}),
    (units.RESISTANCE, {"4.7 k\u2126": 4700.0, "4.7 kΩ": 4700.0, "4.7 kohm": 4700.0}),
    (units.VOLTAGE, {"5 V": 5.0}), (units.CURRENT, {"80 mA": 0.08}),
    (units.AREA, {"0.005 m²": 0.005, "50 cm2": 0.005}),
    (units.FILM, {"8.7 W/m²K": 8.7, "8.7 W/(m²·K)": 8.7}),
]  # fmt: skip


@pytest.mark.parametrize(("dimension", "texts"), READ, ids=[each.name for each, _ in READ])
def test_reads(dimension: Dimension, texts: dict[str, float]) -> None:
    for text, expected in texts.items():
        found = parse(text, dimension)
        assert (text, found) == (text, expected)
        assert math.copysign(1, found) == math.copysign(1, expected)


REFUSED = [
    "", " ", "°C", "1 2 °C", "1e °C", "0x10 °C", "1_000 °C", "nan °C", "inf °C", "1..2 °C",
    "1 °C °C", "١ °C", "1e9999 °C", "1e999 °C", "5 °Ré", "50 % °C", "1,5 °C", "½ °C",
    "１０ °C", "1０ °C", "10³ °C", "10² °C", "1e³ °C", "5¹C", "1⁻² °C", "1½ C",
    "1\u200b °C", "x" * 65 + " °C", "1" + " " * 80 + "°C",
    50, 50.0, math.nan, math.inf, True, None, [], {}, ("50 °C",),
]  # fmt: skip


@pytest.mark.parametrize("value", REFUSED)
def test_refuses(value: object) -> None:
    with pytest.raises(PydanticCustomError) as caught:
        parse(value, units.TEMPERATURE)
    assert caught.value.context is not None
    assert caught.value.context["reason"]
    assert caught.value.context["remedy"]


@given(st.decimals(-1000, 1000, allow_nan=False, allow_infinity=False, places=4))
def test_rounds_once(value: Decimal) -> None:
    assert parse(f"{value} ms", units.DURATION) == float(value / 1000)


@given(st.text(max_size=80))
def test_any_text_is_read_or_refused(text: str) -> None:
    for dimension in DIMENSIONS:
        try:
            assert math.isfinite(parse(text, dimension))
        except PydanticCustomError as error:
            context = error.context or {}
        else:
            continue
        assert context["reason"].isprintable()
        assert context["remedy"]


@pytest.mark.parametrize("text", ["48.5 °C .. 51.9 °C", "48.5 °C..51.9 °C", "119.3 °F .. 51.9 C"])
def test_ranges(text: str) -> None:
    assert QuantityRange(units.TEMPERATURE).read_range(text) == (48.5, 51.9)


@pytest.mark.parametrize(
    "text", ["0 s", "780 ms", "1 s", "1.5 s", "1 min", "90 s", "255 s", "10 min", "1 h"]
)
def test_durations_in_messages_can_be_pasted_back(text: str) -> None:
    assert duration(parse(text, units.DURATION)) == text


@given(st.floats(1e-6, 1e6))
def test_an_advised_limit_is_never_too_little(value: float) -> None:
    assert value * (1 - 1e-12) <= float(rounded_up(value)) <= value * 1.011
    assert abs(float(about(value)) - value) <= value * 0.00501
