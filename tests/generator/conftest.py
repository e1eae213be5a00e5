from collections.abc import Callable, Mapping

import pytest
from rig.specs import files_of

from heatwright.generator import plan_firmware, render
from heatwright.spec import load_text

Generate = Callable[..., Mapping[str, str]]


@pytest.fixture(scope="session")
def generate() -> Generate:
    """From the text of a spec to the files of its firmware."""

    def generated(text: str, file: str = "spec.yaml") -> Mapping[str, str]:
        return render(plan_firmware(load_text(text, file)))

    return generated


@pytest.fixture(scope="session")
def chamber_files() -> Mapping[str, str]:
    return files_of("chamber")
