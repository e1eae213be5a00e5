"""An arena at work, in a process of its own: prepared once, it judges mutant after mutant."""

import contextlib
import multiprocessing
import tempfile
import traceback
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple

from mutation.arena import Arena
from mutation.machine_code import same_machine_code
from mutation.schema import TOGETHER, schema
from mutation.syntax import Mutant
from mutation.trial import Trial

LEAST_S, MOST_TIMES = 2.0, 4.0
"""A mutant hangs that takes longer than this, and this many times what the sound one takes."""


class Verdict(NamedTuple):
    fate: str
    """`killed`, `survived`, `equal` (the same machine code), or `stillborn` (does not compile)."""
    reason: str
    """What killed it."""


class Court:
    """The process, seen from outside."""

    def __init__(self, arena: Arena, mutants: Sequence[Mutant]) -> None:
        fork = multiprocessing.get_context("fork")
        self.connection, there = fork.Pipe()
        self._process = fork.Process(target=_serve, args=(arena, mutants, there), daemon=True)
        self._process.start()
        there.close()

    def judge(self, mutants: Sequence[Mutant], at_once: int) -> None:
        """Ask for verdicts; each comes over the connection as (identity, verdict), then None."""
        self.connection.send((mutants, at_once))

    def close(self) -> None:
        with contextlib.suppress(OSError):  # it may have ended
            self.connection.send(None)
        self._process.join()
        self.connection.close()


def _serve(arena: Arena, mutants: Sequence[Mutant], pipe: Connection) -> None:
    try:
        with tempfile.TemporaryDirectory() as folder:
            bench = _Bench(arena, mutants, Path(folder))
            while (order := _next_order(pipe)) is not None:
                asked, at_once = order
                for identity, verdict in bench.verdicts(asked, at_once):
                    pipe.send((identity, verdict))
                pipe.send(None)
    except Exception:
        pipe.send(("", Verdict("broken", f"{arena.name}: {traceback.format_exc()}")))


def _next_order(pipe: Connection) -> tuple[Sequence[Mutant], int] | None:
    """Nothing when there is nothing left to do, or nobody left to do it for."""
    parent = multiprocessing.parent_process()
    while not pipe.poll(1):
        if parent is None or not parent.is_alive():
            return None
    found: tuple[Sequence[Mutant], int] | None = pipe.recv()
    return found


class _Bench:
    def __init__(self, arena: Arena, mutants: Sequence[Mutant], folder: Path) -> None:
        self._arena, self._folder = arena, folder
        self._sources = arena.sources()
        self._numbers: dict[Mutant, int] = {}
        self._stillborn: set[Mutant] = set()
        together = [each for each in mutants if each.kind in TOGETHER] * arena.together
        self._built = self._all_in_one(together) if together else self._build({}, "sound")
        arena.prepare()
        sound = Trial(arena.problem, self._built, 0, 3600).outcome()
        if sound.problem:
            message = f"the sound firmware has a problem: {sound.problem}"
            raise AssertionError(message)
        self._most_s = max(LEAST_S, MOST_TIMES * sound.seconds)

    def _build(self, changed: Mapping[str, str], name: str) -> Path:
        folder = self._folder / name
        folder.mkdir(exist_ok=True)
        return self._arena.build(changed, folder)

    def _all_in_one(self, mutants: Sequence[Mutant]) -> Path:
        by_file: dict[str, list[Mutant]] = defaultdict(list)
        for mutant in mutants:
            by_file[mutant.file].append(mutant)
        for number, mutant in enumerate(mutants, 1):
            self._numbers[mutant] = number
        try:
            return self._build(self._texts(by_file), "all")
        except Exception:
            for file, those in by_file.items():
                by_file[file] = self._compiling(file, those)
            return self._build(self._texts(by_file), "all")

    def _texts(self, by_file: Mapping[str, Iterable[Mutant]]) -> dict[str, str]:
        texts = {}
        for place, (file, mutants) in enumerate(by_file.items()):
            chosen = {self._numbers[mutant]: mutant for mutant in mutants}
            texts[file] = schema(self._sources[file], chosen, defines=place == 0)
        return texts

    def _compiling(self, file: str, mutants: list[Mutant]) -> list[Mutant]:
        """Those of the mutants with which the file compiles."""
        try:
            self._build(self._texts({file: mutants}), "part")
        except Exception:
            if len(mutants) == 1:
                self._stillborn.add(mutants[0])
                return []
            middle = len(mutants) // 2
            return [*self._compiling(file, mutants[:middle]),
                    *self._compiling(file, mutants[middle:])]  # fmt: skip
        return mutants

    def verdicts(self, mutants: Sequence[Mutant], at_once: int) -> Iterable[tuple[str, Verdict]]:
        running: list[tuple[Mutant, Trial]] = []
        for mutant in mutants:
            if mutant in self._stillborn:
                yield mutant.identity, Verdict("stillborn", "it does not compile")
                continue
            try:
                built, number = self._of(mutant)
            except Exception as problem:
                words = str(problem).strip().splitlines() or [""]
                yield mutant.identity, Verdict("stillborn", words[0])
                continue
            running.append((mutant, Trial(self._arena.problem, built, number, self._most_s)))
            if len(running) == at_once:
                yield self._verdict(*running.pop(0))
        for mutant, trial in running:
            yield self._verdict(mutant, trial)

    def _of(self, mutant: Mutant) -> tuple[Path, int]:
        """The library or program of a mutant, and its number there."""
        if mutant in self._numbers:
            return self._built, self._numbers[mutant]
        changed = {mutant.file: mutant.applied(self._sources[mutant.file])}
        return self._build(changed, mutant.identity), 0

    def _verdict(self, mutant: Mutant, trial: Trial) -> tuple[str, Verdict]:
        outcome = trial.outcome()
        if outcome.problem:
            return mutant.identity, Verdict("killed", outcome.problem)
        headers: Any = getattr(self._arena, "headers", dict)
        texts = {**headers(), **self._sources}
        equal = same_machine_code(mutant.file, texts, mutant.applied(texts[mutant.file]))
        return mutant.identity, Verdict("equal" if equal else "survived", "")
