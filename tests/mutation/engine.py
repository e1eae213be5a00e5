"""All arenas: who judges which mutant, what is known already, and what came of it. A statement that
stands in several firmwares is a line of one template: its mutant is judged in the first arena that
has it, and where it survives, in the next one; any of them may kill it."""

import hashlib
import importlib
import json
import os
import re
import sys
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from multiprocessing.connection import Connection, wait
from pathlib import Path

from mutation.arena import Arena
from mutation.court import Court, Verdict, same_machine_code
from mutation.known import entry_of, names_of
from mutation.syntax import Kind, Mutant, mutants_of

HERE = Path(__file__).parent
TESTS = HERE.parent
ROOT = TESTS.parent
MEMORY = ROOT / "build" / "mutation"
BATCH = 24
ENOUGH_EQUAL = 4
JUDGES, SUFFIXES = (ROOT / "sim", ROOT / "spec"), (".py", ".c", ".h")  # besides the tests' modules
_IMPORT = re.compile(r"^\s*(?:from|import) (?:(?:rig|courses)(?:\.| import ))?(\w+)", re.MULTILINE)


def every_arena() -> list[Arena]:
    """Import `tests/*/arena_*.py` and return their ARENAS; none is compiled for it."""
    arenas: list[Arena] = []
    found = sorted(TESTS.glob("*/arena_*.py"))
    sys.path += [str(path.parent) for path in found if str(path.parent) not in sys.path]
    for path in found:
        arenas += importlib.import_module(path.stem).ARENAS
    return arenas


def in_order(arenas: Iterable[Arena]) -> list[Arena]:
    """Return arenas in the order in which they are asked. First those on this computer, then those
    in the simulator; of each, those of few files first: their judges are made for just these, and
    kill what others let live."""
    return sorted(arenas, key=lambda arena: (not arena.together, len(arena.sources())))


@dataclass
class Case:
    """One mutant, and the arenas that may judge it."""

    places: list[tuple[int, Mutant]]  # number of the arena, and the mutant as it is there
    verdicts: list[Verdict] = field(default_factory=list)

    @property
    def mutant(self) -> Mutant:
        return self.places[0][1]

    @property
    def next(self) -> tuple[int, Mutant] | None:
        """Who judges it next; nobody, if it is dead, or listed and alive, or the same program in
        so many firmwares that it is in all, or no one is left."""
        if self.verdicts and (self.verdicts[-1].fate == "killed" or self._is_listed):
            return None
        if [verdict.fate for verdict in self.verdicts] == ["equal"] * ENOUGH_EQUAL:
            return None
        left = self.places[len(self.verdicts) :]
        return left[0] if left else None

    @property
    def _is_listed(self) -> bool:
        alive = any(verdict.fate == "survived" for verdict in self.verdicts)
        return alive and entry_of(mutant for _, mutant in self.places) is not None

    @property
    def fate(self) -> str:
        fates = {verdict.fate for verdict in self.verdicts}
        return next(
            (each for each in ("killed", "survived", "equal", "stillborn") if each in fates), ""
        )


def cases_of(arenas: Sequence[Arena], file: str = "") -> list[Case]:
    """Return the mutants (of one file, if it is given) that can differ from the original, each
    once, with the arenas in the order in which they judge."""
    cases: dict[str, Case] = {}
    for number, arena in enumerate(arenas):
        sources = arena.sources()
        headers = getattr(arena, "headers", dict)()
        names = names_of({**headers, **sources})
        loops = [name[len("guard_") : -len(".h")] for name in headers if name.startswith("guard_")]
        order = getattr(arena, "interrupted", False)
        for name in sorted(sources):
            if not name.endswith(".c") or (file and name != file):
                continue
            for mutant in mutants_of(name, sources[name], names, loops, order=order):
                case = cases.setdefault(mutant.identity, Case([]))
                if not case.places or case.places[-1][0] != number:
                    case.places.append((number, mutant))
    return [
        case for case in cases.values()
        if all(mutant.kind is not Kind.SAME for _, mutant in case.places)
    ]  # fmt: skip


def sampled(cases: Sequence[Case], number: int) -> list[Case]:
    def place(case: Case) -> bytes:
        return hashlib.sha256(f"0 {case.mutant.identity}".encode()).digest()

    return sorted(cases, key=place)[:number]


class Memory:
    """Verdicts by the content of all that goes into them, in `build/mutation`."""

    def __init__(self, arena: Arena) -> None:
        self._path = MEMORY / f"{arena.name.replace('/', '-')}.json"
        told = (arena.name, sorted(arena.sources().items()), _digest(arena.name.partition("/")[0]))
        self._key = hashlib.sha256(repr(told).encode()).hexdigest()
        self._known: dict[str, list[str]] = {}
        self._changed = False
        if self._path.exists():
            found = json.loads(self._path.read_text(encoding="utf-8"))
            self._known = found["verdicts"] if found["key"] == self._key else {}

    def get(self, mutant: Mutant) -> Verdict | None:
        known = self._known.get(mutant.identity)
        return Verdict(*known) if known else None

    def put(self, mutant: Mutant, verdict: Verdict) -> None:
        self._known[mutant.identity] = list(verdict)
        self._changed = True

    def save(self) -> None:
        if not self._changed:
            return
        MEMORY.mkdir(parents=True, exist_ok=True)
        text = json.dumps({"key": self._key, "verdicts": self._known})
        made = self._path.with_suffix(f".{os.getpid()}")
        made.write_text(text, encoding="utf-8")
        made.replace(self._path)
        self._changed = False


@cache
def _digest(area: str) -> str:
    """Digest what judges an area's arenas: their modules, the C beside them, the simulator, the
    spec's checks, and how mutants are put to trial."""
    folders = TESTS / area, TESTS / "rig"
    files = _imported((TESTS / area).glob("arena_*.py"))
    files |= {path for folder in folders for path in folder.rglob("*.[ch]")}
    files |= {path for folder in JUDGES for path in folder.rglob("*") if path.suffix in SUFFIXES}
    files |= {HERE / "syntax.py", HERE / "court.py"}
    return hashlib.sha256(b"".join(path.read_bytes() for path in sorted(files))).hexdigest()


def _imported(modules: Iterable[Path]) -> set[Path]:
    """Return modules of the tests, and all that they import of them; their names are unique."""
    by_name = {path.stem: path for path in TESTS.glob("*/**/*.py") if path.parent != HERE}
    found, new = set[Path](), set(modules)
    while new:
        found |= new
        names = {name for path in new for name in _IMPORT.findall(path.read_text("utf-8"))}
        new = {by_name[name] for name in names & set(by_name)} - found
    return found


class Engine:
    def __init__(
        self,
        arenas: Sequence[Arena],
        cases: Sequence[Case],
        progress: Callable[[Case], None] = lambda _: None,
    ) -> None:
        self._arenas, self._cases, self._progress = arenas, cases, progress
        self._memories = [Memory(arena) for arena in arenas]
        self._waiting: dict[int, deque[Case]] = defaultdict(deque)
        self._ahead: Counter[int] = Counter()  # by arena: cases that it may still have to judge
        self._mutants: dict[int, list[Mutant]] = defaultdict(list)
        self._courts: dict[int, Court] = {}
        self._busy: dict[Connection, tuple[int, dict[str, Case]]] = {}

    def run(self, at_once: int = 0) -> None:
        at_once = at_once or os.cpu_count() or 1
        for case in self._cases:
            for number, mutant in case.places:
                self._mutants[number].append(mutant)
            self._ahead.update(number for number, _ in case.places)
            self._queue(case)
        try:
            while self._busy or any(self._waiting.values()):
                self._send(at_once)
                for connection in wait(list(self._busy)):
                    assert isinstance(connection, Connection)
                    self._hear(connection)
        finally:
            for memory in self._memories:
                memory.save()
            for court in self._courts.values():
                court.close()

    def _queue(self, case: Case) -> None:
        """Put it before the next arena that does not know it."""
        while case.next is not None:
            number, mutant = case.next
            known = self._memories[number].get(mutant) or self._equal_again(case)
            if known is None:
                self._waiting[number].append(case)
                return
            case.verdicts.append(known)
            self._ahead[number] -= 1
        for number, _ in case.places[len(case.verdicts) :]:
            self._ahead[number] -= 1
        self._progress(case)

    def _equal_again(self, case: Case) -> Verdict | None:
        """What was the same program where it was tried is looked at by the compiler first."""
        if case.next is None or {verdict.fate for verdict in case.verdicts} != {"equal"}:
            return None
        number, mutant = case.next
        arena = self._arenas[number]
        texts = {**getattr(arena, "headers", dict)(), **arena.sources()}
        if not same_machine_code(mutant.file, texts, mutant.applied(texts[mutant.file])):
            return None
        found = Verdict("equal", "")
        self._memories[number].put(mutant, found)
        return found

    def _send(self, at_once: int) -> None:
        working = {number for number, _ in self._busy.values()}
        ready = sorted(number for number, cases in self._waiting.items() if cases)
        ready = [number for number in ready if number not in working]
        for number in ready[: at_once - len(working)]:
            share = at_once if len(ready) + len(working) == 1 else 1
            queue = self._waiting[number]
            cases = [queue.popleft() for _ in range(min(len(queue), BATCH * share))]
            if number not in self._courts:
                self._courts[number] = Court(self._arenas[number], self._mutants[number])
            asked = {}
            for case in cases:
                assert case.next is not None
                asked[case.next[1].identity] = case
            court = self._courts[number]
            court.judge([case.next[1] for case in cases if case.next], share)
            self._busy[court.connection] = number, asked

    def _hear(self, connection: Connection) -> None:
        number, asked = self._busy[connection]
        try:
            told = connection.recv()
        except (EOFError, ConnectionResetError):
            told = "", Verdict("broken", f"{self._arenas[number].name}: its process has ended")
        if told is None:
            del self._busy[connection]
            self._memories[number].save()
            self._close()
            return
        identity, verdict = told
        if verdict.fate == "broken":
            raise AssertionError(verdict.reason)
        case = asked[identity]
        self._memories[number].put(case.places[len(case.verdicts)][1], verdict)
        case.verdicts.append(verdict)
        self._ahead[number] -= 1
        self._queue(case)

    def _close(self) -> None:
        """End the processes of arenas that have nothing left to judge."""
        for number in set(self._courts) - {number for number, _ in self._busy.values()}:
            if self._ahead[number] == 0:
                self._courts.pop(number).close()
