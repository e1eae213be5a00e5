from collections.abc import Mapping
from pathlib import Path

import pytest
from touch_kiln import SPEC, compile_kiln, linked

from heatwright.generator import plan_firmware, render
from heatwright.spec import Controller, Spec, load
from heatwright.spec.nextion import display_pages


@pytest.fixture(scope="session")
def touched_spec(tmp_path_factory: pytest.TempPathFactory) -> Spec:
    path = tmp_path_factory.mktemp("spec") / "touched.yaml"
    path.write_text(SPEC, encoding="utf-8")
    return load(path)


@pytest.fixture(scope="session")
def touched(touched_spec: Spec) -> Controller:
    return touched_spec.controller


@pytest.fixture(scope="session")
def kiln_files(touched_spec: Spec) -> Mapping[str, str]:
    return render(plan_firmware(touched_spec))


@pytest.fixture(scope="session")
def kiln_project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("kiln")


@pytest.fixture(scope="session")
def kiln_objects(kiln_files: Mapping[str, str], kiln_project: Path) -> dict[str, Path]:
    return compile_kiln(kiln_files, kiln_project)


@pytest.fixture(scope="session")
def kiln(kiln_objects: dict[str, Path], kiln_project: Path) -> Path:
    """The kiln's firmware as a program of this computer: see touch_kiln."""
    return linked(kiln_objects, kiln_project / "kiln")


@pytest.fixture(scope="session")
def page_numbers(touched: Controller) -> dict[str, int]:
    return {page.name: page.id for page in display_pages(touched)}
