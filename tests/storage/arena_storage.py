"""What keeps programs, progress and settings, broken: the checks of what is kept must complain."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from host_builds import build_of_spec
from rig.specs import sources_of, spec_of
from storage_host import Kept
from storage_programs import Programs
from storage_progress import Progresses
from storage_settings import SettingsKept
from storage_specs import text_of
from storage_waits import compiled, waits_problem

from heatwright.sim.elf import Elf
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


@dataclass
class WaitsArena:
    """The same files on the simulated processor, whose EEPROM is not ready at once."""

    machine: str
    files: tuple[str, ...]
    together = False

    @property
    def name(self) -> str:
        return f"storage/{self.machine}/waits"

    def sources(self) -> Mapping[str, str]:
        found = sources_of(text_of(self.machine))
        return {name: found[name] for name in self.files}

    def build(self, changed: Mapping[str, str], folder: Path) -> Path:
        del folder  # the rig has its own
        return compiled(self.machine, changed).path

    def prepare(self) -> None:
        """Nothing is shared."""

    def problem(self, built: Path) -> str:
        return waits_problem(self.machine, Elf(built))


ARENAS = [
    StorageArena("few", "programs.c", Programs),
    StorageArena("few", "progress.c", Progresses),
    StorageArena("typed", "settings.c", SettingsKept),
    WaitsArena("few", ("programs.c", "progress.c")),
    WaitsArena("typed", ("settings.c",)),
]
