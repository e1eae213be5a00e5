from pathlib import Path

import pytest
from kiln_desk import Built, KilnDesk

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.elf import Elf
from heatwright.spec import load

EXAMPLE = Path(__file__).parents[2] / "spec" / "examples" / "kiln.yaml"


@pytest.fixture(scope="session")
def kiln(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """The kiln's firmware."""
    folder = tmp_path_factory.mktemp("kiln")
    spec = load(EXAMPLE)
    write(render(plan_firmware(spec)), folder)
    return Built(spec.controller, Elf(build(folder).elf), folder)


@pytest.fixture
def desk(kiln: Built) -> KilnDesk:
    """The kiln, its display started, nothing on."""
    made = KilnDesk(kiln)
    made.run(2.0)
    return made
