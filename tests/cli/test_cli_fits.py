"""A firmware that does not fit its board is told in the spec's terms, and what is told is true."""

import pickle

import pytest
from rig.avr import whole
from rig.commands import Heatwright, changed
from rig.specs import EXAMPLES, example
from rig.specs import changed as text

from heatwright.cli.firmware import build_firmware
from heatwright.cli.fits import DoesNotFit
from heatwright.cli.talk import _PlainJob
from heatwright.generator.toolchain.result import sizes
from heatwright.spec import load_text
from heatwright.spec.least import least


def test_too_many_entries_for_the_ram(heatwright: Heatwright) -> None:
    told = heatwright(f"build {changed('kiln_uno', 'entries: 96', 'entries: 250')} --json", 2)
    build, found = told.json["build"], told.json["too_large"]
    assert found["ram"] == build["ram"] + build["stack"] - build["ram_limit"] > found["flash"] == 0
    assert f"of 2,048 B: {found['ram']} B too many" in told.err
    for memory in ("flash", "ram"):
        assert sum(part[memory] for part in found["parts"]) == build[memory]
    assert heatwright("verify changed.yaml --json", 2).json["too_large"] == found
    most = int(found["savings"][0]["change"].removeprefix("at most "))
    for entries, status in ((most, 0), (most + 1, 2)):
        heatwright(f"build {changed('kiln_uno', 'entries: 96', f'entries: {entries}')}", status)


def test_too_much_for_the_flash() -> None:
    """The linker refuses it. The words come whole from another process, as in a comparison."""
    fan = ("pwm, pin: D9, frequency: 122 Hz", "digital, pin: PB3")
    spec = text("extruder", ("mega2560", "atmega16"), ("A13", "PA0"), ("D10", "PD5"), fan)
    with pytest.raises(DoesNotFit) as caught:
        build_firmware(load_text(spec), _PlainJob("Building"))
    told = str(pickle.loads(pickle.dumps(caught.value)))  # noqa: S301 - our own
    over = caught.value.what.built.flash_bytes - 16384
    assert f"of 16,384 B: {over:,} B too many\n" in told
    assert "interfaces[0]: leave it out: 7," in told
    assert "ld:" not in told


@pytest.mark.parametrize("name", sorted(file.stem for file in EXAMPLES.glob("*.yaml")))
def test_what_check_warns_of_is_certain(name: str) -> None:
    taken, bound = sizes(whole(name).path), least(example(name).controller)
    assert bound.flash <= taken[0] < 2 * bound.flash
