"""What came of the cases: by file and function, and whether that is enough."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from typing import Any

from mutation.engine import Case
from mutation.known import entry_of, listed

PROTECTION = ("guard_", "gate", "fault.", "reset", "relay", "current_", "settings", "programs",
              "progress", "countdown", "proof_", "monitor_")  # fmt: skip
"""Beginnings of the names of files that protect: of them every mutant is killed or listed."""
LEAST_KILLED = 0.95  # share of the mutants of other files, without the equivalent ones


def protects(file: str) -> bool:
    return file.startswith(PROTECTION)


class Report:
    def __init__(self, arenas: Sequence[str], cases: Sequence[Case]) -> None:
        self.arenas, self.cases = arenas, cases

    def fate(self, case: Case) -> str:
        if case.fate == "survived" and entry_of(mutant for _, mutant in case.places):
            return "listed"
        return case.fate

    def by_file(self) -> dict[str, dict[str, list[Case]]]:
        files: dict[str, dict[str, list[Case]]] = defaultdict(lambda: defaultdict(list))
        for case in sorted(self.cases, key=lambda case: case.mutant.file):
            files[case.mutant.file][case.mutant.function].append(case)
        return files

    def counts(self, groups: Iterable[Sequence[Case]]) -> tuple[int, ...]:
        fates = Counter(self.fate(case) for cases in groups for case in cases)
        del fates["stillborn"]
        return (fates.total(), *(fates[kind] for kind in ("killed", "equal", "listed", "survived")))

    def survivors(self) -> list[str]:
        lines = []
        for case in self.cases:
            if self.fate(case) == "survived":
                where = " ".join(self.arenas[number] for number, _ in case.places)
                lines.append(f"SURVIVED {case.mutant}  [{where}]")
        return sorted(lines, key=lambda line: (not protects(line.split()[1]), line))

    def wrong_entries(self) -> list[str]:
        return [
            f"equivalent.txt:{entry.line}: is killed: {case.mutant}"
            for case in self.cases
            if case.fate == "killed" and (entry := entry_of(mutant for _, mutant in case.places))
        ]

    def unused_entries(self) -> list[str]:
        """Entries that fit no mutant; of any use where all mutants are at hand."""
        mutants = {str(mutant) for case in self.cases for _, mutant in case.places}
        unused = [each for each in listed() if not any(map(each.expression.fullmatch, mutants))]
        return [f"equivalent.txt:{each.line}: fits no mutant: {each.pattern}" for each in unused]

    def shares(self) -> tuple[float, float]:
        """Killed of those that can be told, in protection code and elsewhere."""
        found = []
        for kind in (True, False):
            cases = [case for case in self.cases if protects(case.mutant.file) is kind]
            _, killed, _, _, survived = self.counts([cases])
            found.append(killed / (killed + survived) if killed + survived else 1.0)
        return found[0], found[1]

    @property
    def is_well(self) -> bool:
        protection, others = self.shares()
        return protection == 1 and others >= LEAST_KILLED and not self.wrong_entries()

    def verdict(self) -> str:
        protection, others = self.shares()
        return (f"killed: {protection:.2%} of protection code (100% is due), "
                f"{others:.2%} of the rest ({LEAST_KILLED:.0%} is due)")  # fmt: skip

    def data(self) -> list[dict[str, Any]]:
        told = []
        for case in self.cases:
            asked = zip(case.places, case.verdicts, strict=False)
            arenas = {self.arenas[number]: list(verdict) for (number, _), verdict in asked}
            where = {"file": case.mutant.file, "function": case.mutant.function}
            told.append({**where, "mutant": case.mutant.what, "fate": self.fate(case),
                         "arenas": arenas})  # fmt: skip
        return told
