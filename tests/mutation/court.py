"""An arena at work, in a process of its own: prepared once, it judges mutant after mutant."""

import contextlib
import faulthandler
import multiprocessing
import os
import resource
import select
import signal
import subprocess
import tempfile
import time
import traceback
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple

from mutation.arena import Arena
from mutation.syntax import TOGETHER, VARIABLE, Mutant, schema

Judge = Callable[[Path], str]
PIPE_BYTES = 4000
WAITS = 20  # times its processor time may a mutant wait for something that never comes
LEAST_S, MOST_TIMES = 2.0, 4.0
"""A mutant hangs that takes longer than this, and this many times what the sound one takes."""
CHIPS = ("atmega2560", "atmega328p", "atmega32")
"""The first one of which the original compiles: of some the registers have other names."""
FLAGS = ("-O2", "-std=c11", "-fpack-struct=1", "-DF_CPU=16000000UL", "-w", "-g0")


class Verdict(NamedTuple):
    fate: str
    """`killed`, `survived`, `equal` (the same machine code), or `stillborn` (does not compile)."""
    reason: str
    """What killed it."""


class Outcome(NamedTuple):
    problem: str
    """What killed it; empty if nothing did."""
    seconds: float
    """Time of the processor."""


class Trial:
    def __init__(self, judge: Judge, built: Path, number: int, most_s: float) -> None:
        """Begin with one of the mutants of what was built (0: with none of them); after `most_s`
        seconds of the processor it counts as hanging."""
        self._reads, writes = os.pipe()
        self._ends_at = time.monotonic() + WAITS * most_s
        self._most_s = most_s
        self.process = os.fork()
        if self.process == 0:
            os.setpgid(0, 0)
            os.close(self._reads)
            _judge(judge, built, number, most_s, writes)
        os.close(writes)

    def outcome(self) -> Outcome:
        left_s = max(0.0, self._ends_at - time.monotonic())
        heard = bool(select.select([self._reads], [], [], left_s)[0])
        words = os.read(self._reads, PIPE_BYTES).decode(errors="replace") if heard else ""
        os.close(self._reads)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process, signal.SIGKILL)
        _, _, used = os.wait4(self.process, 0)
        seconds = used.ru_utime + used.ru_stime
        if not words:
            words = "-it hangs" if not heard or seconds >= self._most_s else "-it crashes"
        return Outcome(words[1:], seconds)


def _judge(judge: Judge, built: Path, number: int, most_s: float, writes: int) -> None:
    """Never returns. The first character says that there is an answer."""
    faulthandler.disable()  # a crash is a verdict, and nobody's business
    try:
        os.environ[VARIABLE] = str(number)
        resource.setrlimit(resource.RLIMIT_CPU, (int(most_s) + 1, int(most_s) + 2))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        nowhere = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(nowhere, stream)
        try:
            words = "+" + judge(built)
        except BaseException as problem:
            words = f"-{type(problem).__name__}: {problem}"
        os.write(writes, words.encode()[:PIPE_BYTES])
    finally:
        os._exit(0)


class Court:
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


def same_machine_code(file: str, texts: Mapping[str, str], changed: str) -> bool:
    """Compile a file as it is and with another text, among the headers of its firmware."""
    headers = tuple(sorted(item for item in texts.items() if item[0].endswith(".h")))
    for chip in CHIPS:
        original = _original(headers, file, texts[file], chip)
        if original is not None:
            return original == _compiled(headers, file, changed, chip)
    return False


def _compiled(
    headers: tuple[tuple[str, str], ...], file: str, text: str, chip: str
) -> bytes | None:
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for name, content in (*headers, (file, text)):
            (folder / name).write_text(content, encoding="utf-8")
        command = ["avr-gcc", f"-mmcu={chip}", *FLAGS, "-c", file, "-o", "made.o"]
        done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
        return (folder / "made.o").read_bytes() if done.returncode == 0 else None


_original = cache(_compiled)
