"""The chamber, with all its protections, takes no more than the sketch it replaces."""

from pathlib import Path

import pytest

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import BuildResult, build
from heatwright.spec import load

EXAMPLE = Path(__file__).parents[2] / "spec" / "examples" / "chamber.yaml"


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> BuildResult:
    project = tmp_path_factory.mktemp("sizes")
    spec = load(EXAMPLE)
    protection = spec.controller.loops["air"].protection
    assert None not in (
        protection.heating, protection.runaway, protection.frozen, protection.rising_while_off
    )  # fmt: skip
    write(render(plan_firmware(spec)), project)
    return build(project)


def test_not_more_than_the_sketch_with_its_libraries(built: BuildResult) -> None:
    assert built.flash_bytes <= 8826
    assert built.ram_bytes <= 345


def test_our_own_aim_of_three_quarters(built: BuildResult) -> None:
    assert built.flash_bytes <= 6620
    assert built.ram_bytes <= 259


def test_the_board_has_room_for_the_stack(built: BuildResult) -> None:
    assert built.ram_bytes + built.stack_bytes <= built.ram_limit
    assert built.flash_bytes <= built.flash_limit
