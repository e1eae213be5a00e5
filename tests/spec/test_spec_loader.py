import gc
import pickle
from pathlib import Path

import pytest
import yaml

from heatwright.spec import Spec, SpecError, digest, load, load_text
from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.loader import MOST_PROBLEMS
from heatwright.spec.text import LARGEST_FILE

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"
CHAMBER = EXAMPLES / "chamber.yaml"


@pytest.fixture(scope="module")
def text() -> str:
    return CHAMBER.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def chamber() -> Spec:
    return load(CHAMBER)


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.yaml")), ids=lambda file: file.stem)
def test_examples_load_and_carry_their_name(file: Path) -> None:
    spec = load(file)
    assert spec.file_name == file.name
    assert spec.controller.identity.name == file.stem


def test_lines(chamber: Spec, text: str) -> None:
    lines = text.splitlines()

    def line(*path: str | int) -> str:
        return lines[chamber.line(path) - 1].strip()

    assert line("loops", "air", "protection", "maximum") == "maximum: 85 °C"
    assert line("loops", "air", "protection", "heating", "within").startswith("heating:")
    assert line("interfaces", 1, "baud").startswith("- {kind: serial_plotter")
    assert line("outputs", "fan").startswith("fan: {kind: digital")


def test_a_line_of_what_was_left_out_is_that_of_what_holds_it(chamber: Spec, text: str) -> None:
    lines = text.splitlines()
    assert lines[chamber.line(("loops", "air", "protection", "frozen", "for")) - 1].strip() == (
        "protection:"
    )
    assert chamber.line(("comparison", 3)) == 1
    assert chamber.line(()) == 1


def test_line_ends_and_a_byte_order_mark_change_nothing(text: str, chamber: Spec) -> None:
    for data in (
        text.replace("\n", "\r\n").encode(),
        text.replace("\n", "\r").encode(),
        b"\xef\xbb\xbf" + text.encode(),
    ):
        spec = load_text(data, "chamber.yaml")
        assert spec.controller == chamber.controller
        assert spec.line(("safety", "watchdog")) == chamber.line(("safety", "watchdog"))


def test_what_yaml_1_1_would_misread(text: str) -> None:
    spec = load_text(text.replace("heating: {rise: 2 K, within: 120 s}", "heating: off"))
    assert spec.controller.loops["air"].protection.heating is None
    with pytest.raises(SpecError, match="'1:30' does not have the unit of a duration"):
        load_text(text.replace("period: 1 s", "period: 1:30"))
    with pytest.raises(SpecError, match="yes or no is needed"):
        load_text(text.replace("maximum: 70 °C}", "maximum: 70 °C, stored: yes}"))
    octal = text.replace("baud: 9600", "baud: 0009600")
    assert load_text(octal).controller.interfaces[1].baud == 9600  # type: ignore[union-attr]


def test_the_digest_is_of_what_shapes_the_firmware(chamber: Spec, text: str) -> None:
    def other(old: str, new: str) -> str:
        assert old in text
        return load_text(text.replace(old, new)).digest

    assert len(chamber.digest) == 8
    assert int(chamber.digest, 16) >= 0
    assert chamber.digest == digest(chamber.controller)
    assert other("# Air heater", "# Heater") == chamber.digest
    assert other("maximum: 85 °C", "maximum: 185 °F") == chamber.digest
    assert other("minimum: -10 °C\n", "\n") == chamber.digest  # the default
    assert other("ambient: 20 °C", "ambient: 21 °C") == chamber.digest
    assert other("maximum: 85 °C", "maximum: 86 °C") != chamber.digest
    assert other("pin: D3", "pin: D2") != chamber.digest
    assert other("title: Air", "title: The air") != chamber.digest


def test_the_digest_does_not_change_unnoticed(chamber: Spec) -> None:
    """Old firmware is recognised by it: a change of the language's defaults must change it too."""
    assert chamber.digest == "8188a1fd"


def test_a_spec_never_changes(chamber: Spec) -> None:
    controller = chamber.controller
    with pytest.raises(ValueError, match="frozen"):
        controller.safety.watchdog_s = 1.0  # type: ignore[misc]
    sensors = controller.sensors
    assert isinstance(sensors, ReadOnlyDict)
    for change in (
        lambda: sensors.update(other=1),
        lambda: sensors.pop("air"),
        lambda: sensors.__setitem__("air", 1),
        sensors.clear,
    ):
        with pytest.raises(TypeError, match="read-only"):
            change()
    assert pickle.loads(pickle.dumps(controller)) == controller  # noqa: S301
    assert hash(controller) == hash(load(CHAMBER).controller)


def test_messages_carry_the_path_as_given(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        load(tmp_path / "none.yaml")
    file = tmp_path / "wrong.yaml"
    file.write_text("heatwright: 3\n")
    with pytest.raises(SpecError) as caught:
        load(file)
    assert str(caught.value).startswith(f"{file}:1:1: ")


def test_huge_and_endless_files_are_refused() -> None:
    with pytest.raises(SpecError, match="the file has more than"):
        load_text(b"a" * (LARGEST_FILE + 1))
    with pytest.raises(SpecError, match="the file has more than"):
        load("/dev/zero")


def test_without_libyaml(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    """PyYAML may have been installed without its C half; the slower half reads the same."""
    monkeypatch.setattr("heatwright.spec.tree._Loader", yaml.BaseLoader)
    assert load_text(text, "chamber.yaml").controller == load(CHAMBER).controller


@pytest.mark.parametrize(
    "text",
    [
        "k: 1\n" * 60_000,
        "".join(f"key{number}: 1\n" for number in range(20_000)),
        "a: &x [" + "*x, " * 60_000 + "]",
        "[" * 250_000,
        "{a: " * 60_000,
        "- " * 100_000,
        "a: " + "x" * 250_000,
        '"' + "\\x41" * 60_000 + '": 1',
        "? " * 100_000,
        "sensors: {" + ", ".join(f"s{n}: {{kind: ds18b20, pin: A1}}" for n in range(5000)) + "}",
    ],
    ids=lambda text: text[:12],
)
def test_abuse_ends_briefly(text: str) -> None:
    with pytest.raises(SpecError) as caught:
        load_text(text)
    assert 1 <= len(caught.value.problems) <= MOST_PROBLEMS + 1
    assert len(str(caught.value)) < 50_000
    gc.collect()


def test_more_problems_than_help_are_counted() -> None:
    with pytest.raises(SpecError) as caught:
        load_text("".join(f"key{number}: 1\n" for number in range(MOST_PROBLEMS + 50)))
    assert "more problems from here on" in caught.value.problems[-1].reason
