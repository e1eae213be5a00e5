from collections.abc import Mapping
from pathlib import Path

import pytest
from touch_kiln import SPEC, compile_kiln

from heatwright.generator import plan_firmware, render
from heatwright.spec import load


@pytest.fixture(scope="session")
def kiln_files(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, str]:
    path = tmp_path_factory.mktemp("spec") / "touched.yaml"
    path.write_text(SPEC, encoding="utf-8")
    return render(plan_firmware(load(path)))


@pytest.fixture(scope="session")
def kiln(kiln_files: Mapping[str, str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The kiln's firmware as a program of this computer: see touch_kiln."""
    return compile_kiln(kiln_files, tmp_path_factory.mktemp("kiln"), {})
