"""A bench that is served in this process, as the command does."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Thread

from rig.firmware import controller_of, whole

from heatwright.cli.bench.board import Board
from heatwright.cli.bench.server import Server


@dataclass
class Bench:
    """address -- of the page; thread -- the server's."""

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
def serving(spec: str, speed: float = 1.0) -> Iterator[Bench]:
    """Serve the board of a spec (its text, or the name of an example) until the context's end."""
    name = "spec" if "\n" in spec else spec
    board = Board(controller_of(spec), whole(spec), f"{name}.yaml", speed=speed)
    server = Server(board)
    thread = Thread(target=server.run)
    board.start()
    thread.start()
    try:
        yield Bench(board, server, thread)
    finally:
        server.stop()
        thread.join()
        board.stop()
