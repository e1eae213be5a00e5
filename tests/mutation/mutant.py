"""One way to break the generated C."""

from typing import NamedTuple


class Mutant(NamedTuple):
    build: str
    """Name of the specification (host_specs) whose firmware is broken."""
    file: str
    old: str
    """The text to be replaced; it must stand there exactly once."""
    new: str

    @property
    def name(self) -> str:
        """Name it by what it breaks, on one line."""

        def short(text: str) -> str:
            return " ".join(text.split())[:60]

        return f"{self.build}/{self.file}: {short(self.old)} -> {short(self.new) or 'nothing'}"


def mutants(build: str, file: str, *changes: tuple[str, str]) -> list[Mutant]:
    return [Mutant(build, file, old, new) for old, new in changes]
