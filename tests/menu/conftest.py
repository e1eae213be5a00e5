from pathlib import Path

import pytest
from menu_desk import MenuDesk

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.elf import Elf
from heatwright.spec import load

EXAMPLE = Path(__file__).parents[2] / "spec" / "examples" / "kiln_uno.yaml"


@pytest.fixture(scope="session")
def menu_elf(tmp_path_factory: pytest.TempPathFactory) -> Elf:
    """The firmware of the kiln with keys."""
    folder = tmp_path_factory.mktemp("kiln_uno")
    write(render(plan_firmware(load(EXAMPLE))), folder)
    return Elf(build(folder).elf)


@pytest.fixture
def desk(menu_elf: Elf) -> MenuDesk:
    """The kiln, started, nothing on, its first screen shown."""
    made = MenuDesk(load(EXAMPLE).controller, menu_elf)
    made.run(2.5)
    return made
