"""Benches of this process: with somebody at them in this thread, or served as the command does."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Thread
from typing import Any

from rig.firmware import controller_of, whole

from heatwright.cli.bench.board import Board
from heatwright.cli.bench.server import Server
from heatwright.cli.bench.store import Told


def board_of(spec: str, speed: float = 1.0) -> Board:
    name = "spec" if "\n" in spec else spec
    return Board(controller_of(spec), whole(spec), f"{name}.yaml", speed=speed)


class Seated:
    """A board that has run for so long, and stands until `run`; told -- what a tab would know."""

    def __init__(self, spec: str, ran_s: float = 0.0) -> None:
        self.board = board_of(spec)
        self.board.set_speed(0.0)
        self.world = self.board.world
        self.told = Told()
        self.lines: dict[str, list[Any]] = {}
        self.points: dict[str, list[Any]] = {}
        self.run(ran_s)

    def do(self, what: str, **order: Any) -> None:
        assert not (error := self.board.do({"do": what, **order})), error

    def at(self, kind: str, **order: Any) -> None:
        self.do("at", interface=self.number(kind), **order)

    def press(self, key: str, held_s: float = 0.05) -> None:
        self.at("lcd_keypad", key=key, down=True)
        self.at("lcd_keypad", key=key, down=False, held_s=held_s)
        self.run(1.0)

    def fault(self, name: str, *, on: bool = True) -> None:
        self.do("fault", fault=name, on=on)

    def number(self, kind: str) -> int:
        return next(each.number for each in self.board.seats if each.kind == kind)

    def run(self, seconds: float) -> None:
        self.board.go_to(self.world.now_s + seconds)

    @property
    def state(self) -> Any:
        """Tell, and return the whole state as a tab has it."""
        self.board.tell(force=True)
        news = self.board.store.news(self.told)
        for roll, lines in news.get("lines", {}).items():
            self.lines.setdefault(roll, []).extend(lines)
        for loop, course in news.get("charts", {}).items():
            self.points.setdefault(loop, []).extend(course["points"])
        return self.told.state

    def of(self, kind: str) -> Any:
        return self.state["interfaces"][self.number(kind)]

    def missing(self, loop: str) -> list[str]:
        return [each["id"] for each in self.state["loops"][loop]["missing"]]


@dataclass
class Bench:
    board: Board
    server: Server
    thread: Thread

    @property
    def address(self) -> str:
        return self.server.address

    @property
    def origin(self) -> str:
        return self.address.rsplit("/", 2)[0]


@contextmanager
def running(server: Server) -> Iterator[tuple[Server, Thread]]:
    """Let a server answer in a thread of its own until the context's end."""
    thread = Thread(target=server.run)
    thread.start()
    try:
        yield server, thread
    finally:
        server.stop()
        thread.join()


@contextmanager
def serving(spec: str, speed: float = 1.0) -> Iterator[Bench]:
    """Serve the board of a spec (its text, or the name of an example) until the context's end."""
    board = board_of(spec, speed)
    board.start()
    try:
        with running(Server(board)) as (server, thread):
            yield Bench(board, server, thread)
    finally:
        board.stop()
