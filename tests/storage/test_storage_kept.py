"""Programs, progress and settings in EEPROM: under power cuts, damage, noise and wrap."""

from collections.abc import Callable
from functools import cache

import pytest
from storage_host import Kept
from storage_programs import Programs
from storage_progress import Progresses
from storage_settings import SettingsKept
from storage_specs import build_of

from heatwright.sim.host import Host

MACHINES: dict[type[Kept], tuple[str, ...]] = {
    Programs: ("few", "many", "usual"),
    Progresses: ("few", "usual", "pausing"),
    SettingsKept: ("few", "typed", "usual"),
}
CASES = [
    (kind, machine, check)
    for kind, machines in MACHINES.items()
    for machine in machines
    for check in kind.checks
]


@pytest.fixture(scope="session")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Callable[[type[Kept], str], Kept]:
    """What is kept by the host build of a machine."""
    build = cache(lambda machine: build_of(machine, tmp_path_factory.mktemp("storage")))
    return cache(lambda kind, machine: kind(Host(build(machine))))


@pytest.mark.parametrize(("kind", "machine", "check"), CASES)
def test_it_stands(
    kept: Callable[[type[Kept], str], Kept], kind: type[Kept], machine: str, check: str
) -> None:
    tried = kept(kind, machine)
    assert [*getattr(tried, check)(), *tried.beyond()] == []
