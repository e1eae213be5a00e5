import gc
import pickle
from pathlib import Path

import pytest
import yaml
from rig.specs import EXAMPLES, changed, example

from heatwright.spec import Spec, SpecError, digest, load, load_text
from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.loader import MOST_PROBLEMS
from heatwright.spec.text import LARGEST_FILE, Unreadable
from heatwright.spec.tree import parse

CHAMBER = EXAMPLES / "chamber.yaml"
TEXT = CHAMBER.read_text("utf-8")


@pytest.fixture
def chamber() -> Spec:
    return example("chamber")


def test_the_line_of_what_was_left_out_is_the_first(chamber: Spec) -> None:
    """Or that of what holds it: see the comments in generated/."""
    assert (chamber.line(("comparison", 3)), chamber.line(())) == (1, 1)


def test_line_ends_and_a_byte_order_mark_change_nothing(chamber: Spec) -> None:
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
    assert other("ambient: 20 °C", "ambient: 21 °C") == chamber.digest
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


ABUSE = {
    "a key again": "k: 1\n" * 60_000,
    "many keys": "".join(f"key{number}: 1\n" for number in range(20_000)),
    "aliases": "a: &x [" + "*x, " * 60_000 + "]",
    "lists in lists": "[" * 250_000,
    "keys in keys": "{a: " * 60_000,
    "items in items": "- " * 100_000,
    "a long value": "a: " + "x" * 250_000,
    "a long key": '"' + "\\x41" * 60_000 + '": 1',
    "keys of keys": "? " * 100_000,
    "many sensors": "sensors:\n" + "".join(f" s{n}: {{kind: ds18b20}}\n" for n in range(9000)),
}


@pytest.mark.parametrize("way", ABUSE)
def test_abuse_ends_briefly(way: str) -> None:
    with pytest.raises(SpecError) as caught:
        load_text(ABUSE[way])
    assert 1 <= len(caught.value.problems) <= MOST_PROBLEMS + 1
    assert len(str(caught.value)) < 50_000
    if way == "many keys":
        assert "more problems from here on" in caught.value.problems[-1].reason
    gc.collect()


@pytest.mark.parametrize("loader", [yaml.BaseLoader, yaml.CBaseLoader])
@pytest.mark.parametrize("text", ["[", "a: b: c", "\x00", "\ud800"])
def test_any_text_that_is_no_yaml_is_unreadable(
    text: str, loader: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("heatwright.spec.tree._Loader", loader)
    with pytest.raises(Unreadable, match="this is not YAML: "):
        parse(text, "spec.yaml")
