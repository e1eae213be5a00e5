"""A serial line of this computer, with something at its other end."""

import os
import pty
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread


@contextmanager
def answered(turn: Callable[[int, Event], None]) -> Iterator[str]:
    """A line's name; at its other end a turn comes after the other, in a thread, until the end.

    turn -- is given the other end, which does not block, and what is set when all is over.
    """
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    os.set_blocking(ours, False)
    done = Event()

    def run() -> None:
        while not done.is_set():
            turn(ours, done)

    thread = Thread(target=run)
    thread.start()
    try:
        yield os.ttyname(theirs)
    finally:
        done.set()
        thread.join()
        os.close(ours)
        os.close(theirs)
