from pathlib import Path

import pytest
from gcode_world import gcode_world

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.elf import Elf
from heatwright.spec import Controller, load

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"


@pytest.fixture(scope="session")
def extruder() -> Controller:
    return load(EXAMPLES / "extruder.yaml").controller


@pytest.fixture(scope="session")
def feeder() -> Controller:
    return load(EXAMPLES / "feeder.yaml").controller


def built(name: str, folder: Path) -> Elf:
    write(render(plan_firmware(load(EXAMPLES / f"{name}.yaml"))), folder)
    return Elf(build(folder).elf)


@pytest.fixture(scope="session")
def extruder_program(tmp_path_factory: pytest.TempPathFactory) -> Elf:
    return built("extruder", tmp_path_factory.mktemp("extruder"))


@pytest.fixture(scope="session")
def feeder_program(tmp_path_factory: pytest.TempPathFactory) -> Elf:
    return built("feeder", tmp_path_factory.mktemp("feeder"))


@pytest.fixture(scope="session")
def world() -> Path:
    """The extruder's G-code as a program of this computer: see gcode_world."""
    return gcode_world().sanitized().program()
