"""The chamber, with all its protections, takes no more than the sketch it replaces."""

from pathlib import Path

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.spec import load

EXAMPLE = Path(__file__).parents[2] / "spec" / "examples" / "chamber.yaml"


def test_the_chamber_takes_three_quarters_of_the_sketch_and_leaves_room(tmp_path: Path) -> None:
    """The sketch with its libraries takes 8826 bytes of flash and 345 of RAM."""
    spec = load(EXAMPLE)
    protection = spec.controller.loops["air"].protection
    assert None not in (
        protection.heating, protection.runaway, protection.frozen, protection.rising_while_off
    )  # fmt: skip
    write(render(plan_firmware(spec)), tmp_path)
    built = build(tmp_path)
    assert built.flash_bytes <= 6620
    assert built.ram_bytes <= 259
    assert built.ram_bytes + built.stack_bytes <= built.ram_limit
    assert built.flash_bytes <= built.flash_limit
