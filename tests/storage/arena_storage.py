"""What keeps programs, progress and settings, broken: the checks of what is kept must complain."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from host_specs import BuildArena
from rig.firmware import Firmware, spec_of
from storage_host import Kept, Progresses
from storage_programs import Programs
from storage_settings import SettingsKept
from storage_specs import text_of
from test_storage import waiting, waits_problem


class StorageArena(BuildArena):
    def __init__(self, machine: str, file: str, kind: type[Kept]) -> None:
        name = f"storage/{machine}/{file.removesuffix('.c')}"
        super().__init__(name, lambda: spec_of(text_of(machine)))
        self.file, self.kind = file, kind

    def sources(self) -> Mapping[str, str]:
        return {self.file: self.headers()[self.file]}

    def prepare(self) -> None:
        _ = self.built

    def problem(self, built: Path) -> str:
        return self.kind(self.host(built), short=True).problem()


def waits(machine: str, *files: str) -> Firmware:
    """The same files on the simulated processor, whose EEPROM is not ready at once."""
    checks = (partial(waits_problem, machine),)
    return Firmware(f"storage/{machine}/waits", waiting(machine), files, checks)


ARENAS: list[StorageArena | Firmware] = [
    StorageArena("few", "programs.c", Programs), StorageArena("few", "progress.c", Progresses),
    StorageArena("typed", "settings.c", SettingsKept), waits("few", "programs", "progress"),
    waits("typed", "settings"),
]  # fmt: skip
