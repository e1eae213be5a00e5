from pathlib import Path

import pytest
from modbus_build import Build, Built

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.elf import Elf
from heatwright.spec import load

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Build:
    """Build an example with parts of its text replaced; each is built once."""
    known: dict[tuple[str, ...], Built] = {}

    def make(name: str, *replaced: tuple[str, str]) -> Built:
        key = (name, *(part for pair in replaced for part in pair))
        if key not in known:
            folder = tmp_path_factory.mktemp(name)
            text = (EXAMPLES / f"{name}.yaml").read_text()
            for old, new in replaced:
                assert old in text, f"{name}.yaml has no {old!r}"
                text = text.replace(old, new)
            path = folder / f"{name}.yaml"
            path.write_text(text)
            spec = load(path)
            write(render(plan_firmware(spec)), folder / "project")
            known[key] = spec.controller, Elf(build(folder / "project").elf)
        return known[key]

    return make
