"""A firmware that does not fit its board is told in the spec's terms, and what is told is true."""

import pickle
from dataclasses import replace

import pytest
from rig.commands import Heatwright, changed
from rig.firmware import EXAMPLE_NAMES, example, whole
from rig.firmware import changed as text

from heatwright.cli.firmware import build_firmware
from heatwright.cli.fits import DoesNotFit
from heatwright.cli.talk import _PlainJob
from heatwright.generator.toolchain import TooLarge
from heatwright.generator.toolchain.given import given
from heatwright.spec import load_text
from heatwright.spec.board.least import EVERY, Least, least


def test_too_many_entries_for_the_ram(heatwright: Heatwright) -> None:
    told = heatwright(f"build {changed('kiln_uno', 'entries: 96', 'entries: 166')} --json", 2)
    build, found = told.json["build"], told.json["too_large"]
    assert found["ram"] == build["ram"] + build["stack"] - build["ram_limit"] > found["flash"] == 0
    assert f"of 2,048 B: {found['ram']} B too many" in told.err
    for memory in ("flash", "ram"):
        assert sum(part[memory] for part in found["parts"]) == build[memory]
    assert heatwright("verify changed.yaml --json", 2).json["too_large"] == found
    most = int(found["savings"][0]["change"].removeprefix("at most "))
    for entries, status in ((most, 0), (most + 1, 2)):
        heatwright(f"build {changed('kiln_uno', 'entries: 96', f'entries: {entries}')}", status)


def test_the_linkers_refusal_is_measured_and_told_whole_by_another_process() -> None:
    fan = ("pwm, pin: D9, frequency: 122 Hz", "digital, pin: PB3")
    spec = text(
        "extruder",
        ("mega2560", "atmega16"),
        ("A13", "PA0"),
        ("pin: D10, f", "pin: PD5, f"),
        ("pin: D10, p", "pin: PD5, p"),
        fan,
    )
    with pytest.raises(DoesNotFit) as caught:
        build_firmware(load_text(spec), _PlainJob("Building"))
    told = str(pickle.loads(pickle.dumps(caught.value)))  # noqa: S301 - our own
    assert f"of 16,384 B: {caught.value.what.built.flash_bytes - 16384:,} B too many\n" in told
    assert "interfaces[0]: leave it out: 9," in told
    assert "safety.self_checks: false: 6" in told
    assert "ld:" not in told


def test_check_warns_to_the_byte(heatwright: Heatwright, monkeypatch: pytest.MonkeyPatch) -> None:
    spare = 32256 - least(example("chamber").controller).flash
    for over, warned in ((0, []), (1, ["flash: at least 32,257 of 32,256 B: 1 B too many"])):
        monkeypatch.setattr(
            "heatwright.spec.board.least.EVERY", Least(EVERY.flash + spare + over, 0)
        )
        found = heatwright("check --quick chamber.yaml --json").json["warnings"]
        assert [each["reason"] for each in found] == warned


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_a_binary_of_a_byte_too_many_is_refused_and_takes_what_check_counts(name: str) -> None:
    elf, controller = whole(name).path, example(name).controller
    board, bound, built = controller.board, least(controller), given(elf, controller.board)
    assert bound.flash <= built.flash_bytes < 2 * bound.flash
    assert bound.ram <= built.ram_bytes + built.stack_bytes
    for key, free in (("flash_bytes", built.flash_over), ("ram_bytes", built.ram_over)):
        exact = getattr(board, key) + free
        given(elf, replace(board, **{key: exact}))
        with pytest.raises(TooLarge):
            given(elf, replace(board, **{key: exact - 1}))
