from pathlib import Path

import pytest
from variants import BARE, PID, built, varied

from heatwright.sim.elf import Elf
from heatwright.sim.faults.world import Site
from heatwright.spec import Controller, load

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"


@pytest.fixture(scope="session")
def site(chamber: Controller, chamber_elf: Path) -> Site:
    return Site(chamber, Elf(chamber_elf), "air")


@pytest.fixture(scope="session")
def pid_site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    spec = varied("pid", PID)
    return Site(spec.controller, Elf(built(spec, tmp_path_factory.mktemp("pid"))), "air")


@pytest.fixture(scope="session")
def bare_site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    spec = varied("bare", BARE)
    return Site(spec.controller, Elf(built(spec, tmp_path_factory.mktemp("bare"))), "air")


@pytest.fixture(scope="session")
def extruder_site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    spec = load(EXAMPLES / "extruder.yaml")
    return Site(spec.controller, Elf(built(spec, tmp_path_factory.mktemp("extruder"))), "nozzle")


@pytest.fixture(scope="session")
def fabricator_site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    spec = load(EXAMPLES / "fabricator.yaml")
    return Site(spec.controller, Elf(built(spec, tmp_path_factory.mktemp("fabricator"))), "nozzle")


@pytest.fixture(scope="session")
def kiln_site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    spec = load(EXAMPLES / "kiln.yaml")
    return Site(spec.controller, Elf(built(spec, tmp_path_factory.mktemp("kiln"))), "chamber")


@pytest.fixture(scope="session")
def menu_site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    spec = load(EXAMPLES / "kiln_uno.yaml")
    return Site(spec.controller, Elf(built(spec, tmp_path_factory.mktemp("kiln_uno"))), "chamber")
