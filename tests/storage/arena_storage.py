"""What keeps programs, progress and settings, broken: the checks of what is kept must complain."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from host_specs import build_of_spec
from rig.firmware import Firmware, sources_of, spec_of
from storage_host import Kept, Progresses
from storage_programs import Programs
from storage_settings import SettingsKept
from storage_specs import text_of
from test_storage import waiting, waits_problem

from heatwright.sim.host import Host, HostBuild


@dataclass
class StorageArena:
    """One of the files of a machine's host build; all its mutants are one library."""

    machine: str
    file: str
    kind: type[Kept]
    together = True

    @property
    def name(self) -> str:
        return f"storage/{self.machine}/{self.file.removesuffix('.c')}"

    def sources(self) -> Mapping[str, str]:
        return {self.file: sources_of(text_of(self.machine))[self.file]}

    def headers(self) -> Mapping[str, str]:
        return sources_of(text_of(self.machine))

    @property
    def _build(self) -> HostBuild:
        return build_of_spec(spec_of(text_of(self.machine)), sanitized=False)

    def build(self, changed: Mapping[str, str], folder: Path) -> Path:
        built = self._build
        for name, text in changed.items():
            built = built.with_changed(name, text, folder)
        return built.library

    def prepare(self) -> None:
        """Compile what is not broken."""
        _ = self._build

    def problem(self, built: Path) -> str:
        return self.kind(Host(replace(self._build, library=built)), short=True).problem()


def waits(machine: str, *files: str) -> Firmware:
    """The same files on the simulated processor, whose EEPROM is not ready at once."""
    checks = (partial(waits_problem, machine),)
    return Firmware(f"storage/{machine}/waits", waiting(machine), files, checks)


ARENAS: list[StorageArena | Firmware] = [
    StorageArena("few", "programs.c", Programs),
    StorageArena("few", "progress.c", Progresses),
    StorageArena("typed", "settings.c", SettingsKept),
    waits("few", "programs", "progress"),
    waits("typed", "settings"),
]
