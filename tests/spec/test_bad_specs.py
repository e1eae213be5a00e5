"""Every file in tests/bad_specs is refused with exactly the messages in the file beside it."""

from pathlib import Path

import pytest

from heatwright.spec import Controller, SpecError, load_text
from heatwright.spec.checks import CHECKS, SIMULATION_CHECKS
from heatwright.spec.checks.finding import Check, Findings
from heatwright.spec.checks.thermal import thermal

FOLDER = Path(__file__).parents[1] / "bad_specs"
FILES = sorted(FOLDER.glob("*.yaml"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_messages(file: Path) -> None:
    with pytest.raises(SpecError) as caught:
        load_text(file.read_bytes(), file.name)
    assert f"{caught.value}\n" == file.with_suffix(".expected").read_text(encoding="utf-8")


def test_every_file_has_its_messages_and_the_other_way_round() -> None:
    found = {file.stem for file in FOLDER.iterdir() if file.suffix == ".expected"}
    assert found == {file.stem for file in FILES}
    assert all(file.suffix in {".yaml", ".expected"} for file in FOLDER.iterdir())


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_messages_stand_in_the_order_of_the_file(file: Path) -> None:
    with pytest.raises(SpecError) as caught:
        load_text(file.read_bytes(), file.name)
    places = [(problem.line, problem.column) for problem in caught.value.problems]
    assert places == sorted(places)


@pytest.fixture(scope="module")
def told() -> set[str]:
    """The names of the checks of which some file's messages tell a finding."""
    found: set[str] = set()

    def listening(check: Check) -> Check:
        def listen(controller: Controller) -> Findings:
            for finding in check(controller):
                if f": {finding.reason}. {finding.remedy}" in expected.replace("by default, ", ""):
                    found.add(check.__name__)
                yield finding

        return listen

    with pytest.MonkeyPatch.context() as patch:
        module = "heatwright.spec.checks"
        for name, table in (("CHECKS", CHECKS), ("SIMULATION_CHECKS", SIMULATION_CHECKS)):
            patch.setattr(f"{module}.{name}", tuple(listening(each) for each in table))
        for file in FILES:
            expected = file.with_suffix(".expected").read_text(encoding="utf-8")
            with pytest.raises(SpecError):
                load_text(file.read_bytes(), file.name)
    return found


@pytest.mark.parametrize("check", CHECKS + SIMULATION_CHECKS, ids=lambda check: check.__name__)
def test_no_check_without_a_file_that_needs_it(check: Check, told: set[str]) -> None:
    assert check.__name__ in told


def test_no_physics_without_a_file_that_needs_it() -> None:
    expected = "".join(file.with_suffix(".expected").read_text(encoding="utf-8") for file in FILES)
    for words in (
        "never reaches the highest setpoint",
        "alone heats to",
        "healthy and at full power, needs",
        "healthy and at full power, rises by",
        "coasts up to",
        "goes on rising for",
        "swings by",
        "it leaves",
        "on this plant falls by",
        "through the whole band",
        "W cannot follow",
    ):
        assert words in expected
    assert thermal.__module__ == "heatwright.spec.checks.thermal"
